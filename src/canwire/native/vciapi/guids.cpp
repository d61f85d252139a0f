// The GUIDs themselves, for programs that do not define them with initguid.h.
#include <initguid.h>

#include <vcisdk.h>

DEFINE_GUID(IID_IUnknown, 0x00000000, 0x0000, 0x0000, 0xC0, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x46);
