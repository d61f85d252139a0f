/* How the numbers of DeviceIoControl are made. */
#ifndef CANWIRE_WINIOCTL_H
#define CANWIRE_WINIOCTL_H
#define METHOD_BUFFERED 0
#define METHOD_IN_DIRECT 1
#define METHOD_OUT_DIRECT 2
#define METHOD_NEITHER 3
#define FILE_ANY_ACCESS 0
#define FILE_READ_ACCESS 1
#define FILE_WRITE_ACCESS 2
#define CTL_CODE(type, function, method, access) ((unsigned)(type) << 16 | (access) << 14 | (function) << 2 | (method))
#endif
