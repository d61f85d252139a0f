/* COM's part of C++ and C: GUIDs, IUnknown, and the words that interfaces are declared with. */
#ifndef CANWIRE_OBJBASE_H
#define CANWIRE_OBJBASE_H
#include <windows.h>

#ifndef GUID_DEFINED
#define GUID_DEFINED
typedef struct _GUID {
    UINT32 Data1;
    UINT16 Data2;
    UINT16 Data3;
    UINT8 Data4[8];
} GUID, *PGUID, *LPGUID, IID, *LPIID, CLSID, *LPCLSID, UUID;
#endif

#ifdef __cplusplus
#define EXTERN_C extern "C"
typedef const GUID &REFGUID;
typedef const IID &REFIID;
typedef const CLSID &REFCLSID;

inline bool operator==(const GUID &one, const GUID &other)
{
    return memcmp(&one, &other, sizeof one) == 0;
}

inline bool operator!=(const GUID &one, const GUID &other)
{
    return !(one == other);
}

#define IsEqualGUID(one, other) ((one) == (other))
#else
#define EXTERN_C extern
typedef const GUID *REFGUID;
typedef const IID *REFIID;
typedef const CLSID *REFCLSID;
#define IsEqualGUID(one, other) (memcmp((one), (other), sizeof(GUID)) == 0)
#endif
#define IsEqualIID IsEqualGUID
#define IsEqualCLSID IsEqualGUID

#define STDMETHODCALLTYPE
#define STDAPICALLTYPE
#define interface struct
#ifdef __cplusplus
#define STDMETHOD(name) virtual HRESULT name
#define STDMETHOD_(type, name) virtual type name
#define PURE = 0
#define THIS_
#define THIS void
#define DECLARE_INTERFACE(name) struct name
#define DECLARE_INTERFACE_(name, base) struct name : public base

/* The order of these three, and no virtual destructor, is what every compiler of COM agrees on. */
struct IUnknown {
    virtual HRESULT QueryInterface(REFIID riid, PVOID *ppv) = 0;
    virtual ULONG AddRef(void) = 0;
    virtual ULONG Release(void) = 0;
};
typedef IUnknown *LPUNKNOWN, *PUNKNOWN;
#else
#define STDMETHOD(name) HRESULT(*name)
#define STDMETHOD_(type, name) type(*name)
#define PURE
#define THIS_ INTERFACE *This,
#define THIS INTERFACE *This
#define DECLARE_INTERFACE(name)                                                                                        \
    typedef struct name {                                                                                              \
        const struct name##Vtbl *lpVtbl;                                                                               \
    } name;                                                                                                            \
    typedef struct name##Vtbl name##Vtbl;                                                                              \
    struct name##Vtbl
#define DECLARE_INTERFACE_(name, base) DECLARE_INTERFACE(name)
#endif

/* GUIDs are in the library that their interfaces are in; with INITGUID (initguid.h) the program has its own. */
#define CANWIRE_GUID(name) EXTERN_C __attribute__((visibility("default"))) const GUID name
#ifdef INITGUID
#ifdef __cplusplus
#define DEFINE_GUID(name, a, b, c, d, e, f, g, h, i, j, k)                                                             \
    EXTERN_C __attribute__((weak, visibility("default"))) const GUID name;                                             \
    const GUID name = {a, b, c, {d, e, f, g, h, i, j, k}}
#else
#define DEFINE_GUID(name, a, b, c, d, e, f, g, h, i, j, k)                                                             \
    __attribute__((weak)) const GUID name = {a, b, c, {d, e, f, g, h, i, j, k}}
#endif
#else
#define DEFINE_GUID(name, a, b, c, d, e, f, g, h, i, j, k) CANWIRE_GUID(name)
#endif

#ifdef __cplusplus
inline HRESULT CoInitialize(LPVOID)
{
    return S_OK;
}

inline void CoUninitialize(void)
{
}
#endif
#endif
