/* GUIDs of headers that follow are defined here, in the program. */
#ifndef INITGUID
#define INITGUID
#endif
#include <objbase.h>
