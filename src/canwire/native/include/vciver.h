/* The version of VCI whose manual canwire follows. */
#ifndef CANWIRE_VCIVER_H
#define CANWIRE_VCIVER_H
#include <stdtype.h>

#define VCI_MAJOR_VERSION 4
#define VCI_MINOR_VERSION 0

#endif
