#ifndef CANWIRE_WINDEF_H
#define CANWIRE_WINDEF_H
#include <windows.h>
#endif
