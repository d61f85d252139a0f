/* Text of either width by one name. */
#ifndef CANWIRE_TCHAR_H
#define CANWIRE_TCHAR_H
#include <windows.h>
#define _T(quoted) TEXT(quoted)
#define _TEXT(quoted) TEXT(quoted)
#ifdef UNICODE
#define _tprintf wprintf
#define _tcslen wcslen
#define _tcscpy wcscpy
#define _tcscmp wcscmp
#else
#define _tmain main
#define _tWinMain main
#define _tprintf printf
#define _ftprintf fprintf
#define _stprintf sprintf
#define _sntprintf snprintf
#define _tcslen strlen
#define _tcscpy strcpy
#define _tcsncpy strncpy
#define _tcscat strcat
#define _tcscmp strcmp
#define _tcsicmp strcasecmp
#define _tcschr strchr
#define _tcsstr strstr
#define _tcstol strtol
#define _tcstoul strtoul
#define _ttoi atoi
#define _tscanf scanf
#define _puttchar putchar
#define _gettchar getchar
typedef int _TINT;
typedef char _TCHAR;
#endif
#endif
