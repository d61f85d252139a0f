/* Types and sizes that VCI's structures are made of. */
#ifndef CANWIRE_STDTYPE_H
#define CANWIRE_STDTYPE_H
#include <windows.h>
#ifdef _WIN32 /* the rest of COM, where windows.h leaves it out; and a name that no header of Windows has */
#include <objbase.h>
typedef GUID *PGUID;
#endif

typedef UINT8 BOOL8, *PBOOL8;
typedef UINT16 BOOL16, *PBOOL16;
typedef INT32 BOOL32, *PBOOL32;

#ifndef CANWIRE_SIZE
#ifdef __cplusplus
#define CANWIRE_SIZE(name, size) static_assert(sizeof(name) == (size), "as the driver has it")
#else
#define CANWIRE_SIZE(name, size) _Static_assert(sizeof(name) == (size), "as the driver has it")
#endif
#endif

#endif
