/* ACAN's calls as the manual tells how to use them; a node outside (../test_acan.py) takes part. */
#include "ACAN.H"
#include "checks.h"

#define ROOM 16

static struct {
    ACANTB block;
    ACANID idTable[4];
} task;
static ACANMB fifo[ROOM], buffer[4];
static BYTE heard[8], temperature[2] = {0x12, 0x34};
static HANDLE called;
static ACANMB messages[64];
static int message_count, overflows;
static WORD conditions;

/* "The recommended method for ACAN event processing" */
static void CALLBACK OnCan(LPACANTB lpTB)
{
    WORD wStatus;
    int count;

    CHECK(lpTB == &task.block && lpTB->dwRefData == 4711);
    while ((wStatus = ACAN_AckEvent(lpTB)) != 0) {
        if (wStatus & TBS_OVERFLOW)
            overflows++;
        if (wStatus & TBS_SC)
            conditions |= HIBYTE(wStatus);
        if (wStatus & TBS_MB)
            while ((count = ACAN_RetrieveMessages(lpTB)) > 0) {
                memcpy(messages + message_count, buffer, count * ACANMBSZ);
                message_count += count;
            }
    }
    SetEvent(called);
}

static void until(int count)
{
    while (message_count < count)
        CHECK(WaitForSingleObject(called, 30000) == WAIT_OBJECT_0);
    CHECK(message_count == count);
}

static void before_init(void)
{
    ACANHI hi;
    ACANMB message = {0};

    CHECK(ACAN_GetDriverVersion() == 0 && ACAN_GetInitStatus() == 0 && ACAN_BusControl(BUS_ON) == 0);
    CHECK(!ACAN_GetHardConfig(&hi) && !ACAN_SendMessage(&message, 1) && !ACAN_Register(&task.block));
}

static void the_hardware(void)
{
    ACANHI hi = {0}, found;

    CHECK(ACAN_Init() == 0x0100 && ACAN_Init() == 0x0100 && ACAN_GetDriverVersion() == 0x0100);
    CHECK(LOBYTE(ACAN_GetInitStatus()) == CANC_SJA1000);
    hi.hi_clk = 16000;
    hi.hi_rat = 500;
    hi.hi_ts1 = 11;
    hi.hi_ts2 = 5;
    hi.hi_sjw = 1;
    hi.hi_ocr = 0x6A;
    CHECK(!ACAN_SetHardConfig(NULL) && !ACAN_GetHardConfig(NULL));
    hi.hi_ts1 = 1;
    CHECK(!ACAN_SetHardConfig(&hi));
    hi.hi_ts1 = 11;
    CHECK(ACAN_SetHardConfig(&hi) && HIBYTE(ACAN_GetInitStatus()) != 0);
    CHECK(ACAN_GetHardConfig(&found) && memcmp(&found, &hi, ACANHISZ) == 0);
}

static void registering(void)
{
    LPACANTB lpTB = &task.block;

    CHECK(ACANMBSZ == 14);
    lpTB->cbNotification = OnCan;
    lpTB->dwRefData = 4711;
    lpTB->bSCFilter = SC_BUSERR | SC_BUSOFF;
    lpTB->wRMBSize = ROOM;
    lpTB->lpBuf = buffer;
    lpTB->wCount = ARRAYSIZE(buffer);
    lpTB->bNId = 4;
    task.idTable[0] = (ACANID){0x1FFFFFFF, 0x123 << 18, IDA_NOTIFY | IDA_QUEUEMSG};
    task.idTable[1] = (ACANID){0x1FFFFFFF, 0x100 << 18, IDA_NOTIFY | IDA_CHANRCV, 8, {0}, heard};
    task.idTable[2] = (ACANID){0x1FFFFFFF, 0x200 << 18, IDA_CHANSND, 2, {0}, temperature};
    task.idTable[3] = (ACANID){0x1FFFFFFF, 0x124 << 18, IDA_QUEUEMSG};
    CHECK(!ACAN_Register(NULL) && !ACAN_Register(lpTB)); /* without a FIFO */
    lpTB->lpRMB = fifo;
    task.idTable[2].lpAddress = NULL;
    CHECK(!ACAN_Register(lpTB));
    task.idTable[2].lpAddress = temperature;
    CHECK(ACAN_AckEventCheck(lpTB) == 0 && ACAN_RetrieveMessages(lpTB) == -1 && !ACAN_Deregister(lpTB));
    CHECK(ACAN_Register(lpTB) && !ACAN_Register(lpTB));
    CHECK(lpTB->bNotType == TBNT_EVENT && lpTB->hEvent != NULL && lpTB->wStatus == 0);
    CHECK(ACAN_BusControl(BUS_ON) == MAKEWORD(BUS_ON, BUS_OFF) && ACAN_BusControl(BUS_ON) == MAKEWORD(BUS_ON, BUS_ON));
}

static void messages_come(void)
{
    puts("send"); /* 0x123 three times, 0x100 with three bytes, 0x200 asking for its value, 0x123 once more */
    fflush(stdout);
    until(4);
    CHECK(messages[0].dwID == 0x123 << 18 && messages[0].bLength == 2 && messages[0].bData[1] == 0x55);
    CHECK(messages[2].bLength == 0 && messages[3].bFormat == FF_RTR);
    CHECK(memcmp(heard, "abc\0\0\0\0", 8) == 0 && overflows == 0 && task.block.wRMBOccupation == 0);
}

static void messages_go(void)
{
    ACANMB message = {0x321 << 18, 0, 8, "12345678"};

    CHECK(ACAN_SendMessage(&message, 1));
    message = (ACANMB){0x1ABCDEF0, FF_EXTENDED, 1, {9}};
    CHECK(ACAN_SendMessage(&message, 255));
    message = (ACANMB){0x123 << 18, 0, 1, {7}};
    CHECK(ACAN_SendMessage(&message, 0)); /* and it is heard here, too */
    until(5);
    CHECK(messages[4].bData[0] == 7);
    message.bLength = 9;
    CHECK(!ACAN_SendMessage(&message, 1) && !ACAN_SendMessage(NULL, 1));
}

/* What the driver keeps is current in a block that nobody acknowledges, and its event is set where nothing is called. */
static void without_a_callback(void)
{
    static struct {
        ACANTB block;
        ACANID any;
    } other;
    ACANMB message = {0x555 << 18, 0, 0};

    other.any = (ACANID){0x1FFFFFFF, 0x555 << 18, IDA_NOTIFY | IDA_QUEUEMSG};
    other.block.lpRMB = fifo;
    other.block.wRMBSize = 2;
    other.block.bNId = 1;
    CHECK(ACAN_Register(&other.block));
    for (int k = 0; k < 3; k++)
        CHECK(ACAN_SendMessage(&message, 0));
    CHECK(WaitForSingleObject(other.block.hEvent, 30000) == WAIT_OBJECT_0);
    while (other.block.wStatus != (TBS_MB | TBS_OVERFLOW))
        Sleep(1);
    CHECK(other.block.wRMBOccupation == 2);
    CHECK(ACAN_RetrieveMessages(&other.block) == -1); /* lpBuf is NULL */
    other.block.lpBuf = buffer;
    other.block.wCount = 1;
    CHECK(ACAN_RetrieveMessages(&other.block) == 1 && other.block.wRMBOccupation == 1 && other.block.wRIndex == 1);
    CHECK(ACAN_AckEventCheck(&other.block) == (TBS_MB | TBS_OVERFLOW) && other.block.wStatus == 0);
    CHECK(ACAN_Deregister(&other.block) && !ACAN_Deregister(&other.block));
    CHECK(ACAN_AckEventCheck(&other.block) == 0);
}

static void memory(void)
{
    BYTE *piece = ACAN_AllocFixedMemory(100);

    CHECK(piece != NULL && piece[99] == 0 && ACAN_AllocFixedMemory(0) == NULL);
    CHECK(!ACAN_FreeFixedMemory(piece, 99) && !ACAN_FreeFixedMemory(NULL, 100));
    CHECK(ACAN_FreeFixedMemory(piece, 100) && !ACAN_FreeFixedMemory(piece, 100));
}

int main(void)
{
    called = CreateEvent(NULL, FALSE, FALSE, NULL);
    before_init();
    the_hardware();
    registering();
    messages_come();
    messages_go();
    without_a_callback();
    memory();
    CHECK(getchar() != EOF); /* everything has arrived */
    CHECK(ACAN_BusControl(BUS_OFF) == MAKEWORD(BUS_OFF, BUS_ON));
    CHECK(ACAN_Deregister(&task.block));
    ACAN_Exit();
    CHECK(ACAN_GetDriverVersion() == 0);
    ACAN_Exit();
    CHECK(ACAN_Init() == 0x0100 && ACAN_Register(&task.block) && ACAN_Deregister(&task.block));
    puts("ACAN did what it says");
    return 0;
}
