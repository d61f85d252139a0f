#ifndef CANWIRE_BASETSD_H
#define CANWIRE_BASETSD_H
#include <windows.h>
#endif
