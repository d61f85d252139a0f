/* The one function of Windows' bcryptprimitives.dll that Rust's programs ask for (eclipse-zenoh): Wine 8 has no such dll. */
#include <windows.h>

BOOLEAN NTAPI SystemFunction036(PVOID, ULONG);

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T size)
{
    return SystemFunction036(data, (ULONG)size);
}
