#ifndef CANWIRE_WINERROR_H
#define CANWIRE_WINERROR_H
#include <windows.h>
#endif
