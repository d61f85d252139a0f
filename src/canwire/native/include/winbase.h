#ifndef CANWIRE_WINBASE_H
#define CANWIRE_WINBASE_H
#include <windows.h>
#endif
