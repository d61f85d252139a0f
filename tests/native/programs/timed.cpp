/* Programs that keep one time: a tester asks at moments of its own, and an ECU answers, or says that nobody asked.
 * A critical section, a thread and its end, timeouts and clocks are the hub's time. */
#include "vci.h"

#include <process.h>
#include <string.h>

static CRITICAL_SECTION section;
static HANDLE stop;
static int ticks;

static CANMSG message(UINT32 identifier, UINT8 byte)
{
    CANMSG made = {};

    made.dwMsgId = identifier;
    made.uMsgInfo.Bits.dlc = 1;
    made.abData[0] = byte;
    return made;
}

/* Holds the section while it sleeps, so that the other thread finds it taken. */
static unsigned tick(void *)
{
    while (WaitForSingleObject(stop, 7) == WAIT_TIMEOUT) {
        EnterCriticalSection(&section);
        ticks++;
        Sleep(3);
        LeaveCriticalSection(&section);
    }
    return 5;
}

static void tester(Line &line)
{
    HANDLE thread = (HANDLE)_beginthreadex(NULL, 0, tick, NULL, 0, NULL);
    DWORD code;

    for (UINT8 number = 0; number < 8; number++) {
        CANMSG asked = message(0x7DF, number);
        OK(line.writer->PutDataEntry(&asked));
        CANMSG answer = line.next();
        EnterCriticalSection(&section);
        printf("%u: %X %u at %u, tick %d\n", (unsigned)GetTickCount(), answer.dwMsgId, answer.abData[0], answer.dwTime, ticks);
        LeaveCriticalSection(&section);
        Sleep(number * 5u);
    }
    SetEvent(stop);
    TRUE_THAT(WaitForSingleObject(thread, INFINITE) == WAIT_OBJECT_0 && GetExitCodeThread(thread, &code) && code == 5);
}

static void ecu(Line &line)
{
    HANDLE arrived = CreateEvent(NULL, FALSE, FALSE, NULL);
    CANMSG got;

    OK(line.reader->AssignEvent(arrived));
    for (int silent = 0; silent < 2;) {
        DWORD found = WaitForSingleObject(arrived, 25);
        TRUE_THAT(found == WAIT_OBJECT_0 || found == WAIT_TIMEOUT);
        silent = found == WAIT_TIMEOUT ? silent + 1 : 0;
        while (line.reader->GetDataEntry(&got) == VCI_OK)
            if (got.uMsgInfo.Bytes.bType == CAN_MSGTYPE_DATA && got.dwMsgId == 0x7DF) {
                CANMSG answer = message(0x101, got.abData[0]);
                OK(line.writer->PutDataEntry(&answer));
            }
    }
    printf("silent at %u\n", (unsigned)GetTickCount());
}

int main(int, char **words)
{
    bool asks = strstr(words[0], "tester") != NULL;
    Line line(asks ? 0 : 1);

    InitializeCriticalSection(&section);
    stop = CreateEvent(NULL, TRUE, FALSE, NULL);
    asks ? tester(line) : ecu(line);
    return 0;
}
