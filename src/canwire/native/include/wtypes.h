#ifndef CANWIRE_WTYPES_H
#define CANWIRE_WTYPES_H
#include <windows.h>
#endif
