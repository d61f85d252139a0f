/* The keyboard, key by key. Without a terminal keys are the bytes of the standard input. */
#ifndef CANWIRE_CONIO_H
#define CANWIRE_CONIO_H
#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)
int _kbhit(void);
int _getch(void); /* -1 at the end of the input */
int _getche(void);
int _putch(int character);
#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#define kbhit _kbhit
#define getch _getch
#define getche _getche
#define putch _putch
#define _cputs(text) fputs((text), stdout)
#define _cprintf printf
#endif
