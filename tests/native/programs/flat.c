/* The flat interface, with CAN FD where FD is defined: two boards, one frame, and what is refused. */
#ifdef FD
#include <vcinpl2.h>
#define CHANNEL_REST , 0, CAN_FILTER_PASS
typedef CANMSG2 MESSAGE;
#else
#include <vcinpl.h>
#define CHANNEL_REST
typedef CANMSG MESSAGE;
#endif
#include "vci.h"

static HANDLE device[2], channel[2], control[2];

static void open_board(int k, HANDLE devices)
{
    VCIDEVICEINFO info;

    OK(vciEnumDeviceNext(devices, &info));
    OK(vciDeviceOpen(&info.VciObjectId, &device[k]));
    OK(canChannelOpen(device[k], 0, FALSE, &channel[k]));
    EXPECT(canChannelPeekMessage(channel[k], &(MESSAGE){0}), VCI_E_NOT_INITIALIZED);
    OK(canChannelInitialize(channel[k], 1024, 1, 128, 1 CHANNEL_REST));
    OK(canChannelActivate(channel[k], TRUE));
    OK(canControlOpen(device[k], 0, &control[k]));
#ifdef FD
    CANBTP rate = CAN_BTP_500KB, none = CAN_BTP_EMPTY;
    OK(canControlInitialize(control[k], CAN_OPMODE_STANDARD, 0, CAN_FILTER_PASS, CAN_FILTER_PASS, 0, 0, &rate, &none));
#else
    OK(canControlInitialize(control[k], CAN_OPMODE_STANDARD, CAN_BT01_500KB));
#endif
    OK(canControlStart(control[k], TRUE));
}

static MESSAGE next_data(HANDLE from)
{
    MESSAGE message;

    do
        OK(canChannelReadMessage(from, 10000, &message));
    while (message.uMsgInfo.Bytes.bType != CAN_MSGTYPE_DATA);
    return message;
}

/* Reads without a limit until the channel is closed in another thread. */
static DWORD WINAPI reads_for_ever(LPVOID begins)
{
    MESSAGE message;
    HRESULT result;

    SetEvent((HANDLE)begins);
    do
        result = canChannelReadMessage(channel[1], INFINITE, &message);
    while (result == VCI_OK);
    return (DWORD)result;
}

static void close_under_readers(void)
{
    HANDLE reader[2], begins = CreateEventA(NULL, FALSE, FALSE, NULL);
    DWORD result;

    for (int k = 0; k < 2; k++) {
        reader[k] = CreateThread(NULL, 0, reads_for_ever, begins, 0, NULL);
        TRUE_THAT(WaitForSingleObject(begins, 60000) == WAIT_OBJECT_0);
    }
    OK(canChannelClose(channel[1]));
    for (int k = 0; k < 2; k++) {
        TRUE_THAT(WaitForSingleObject(reader[k], 60000) == WAIT_OBJECT_0);
        TRUE_THAT(GetExitCodeThread(reader[k], &result) && (HRESULT)result == VCI_E_INVHANDLE);
    }
}

int main(void)
{
    MESSAGE message = {0}, many[3];
    HANDLE devices, monitor;
    UINT32 done, index;

    OK(vciInitialize());
    OK(vciEnumDeviceOpen(&devices));
    open_board(0, devices);
    open_board(1, devices);
    OK(vciEnumDeviceClose(devices));

    message.dwMsgId = 0x321;
    message.uMsgInfo.Bits.dlc = 2;
    message.abData[1] = 0x5A;
    OK(canChannelSendMessage(channel[0], 1000, &message));
    TRUE_THAT(next_data(channel[1]).abData[1] == 0x5A);
    many[0] = many[1] = many[2] = message;
    OK(canChannelSendMsgMult(channel[1], 1000, many, 3, &done));
    TRUE_THAT(done == 3);
    for (int k = 0; k < 3; k++)
        TRUE_THAT(next_data(channel[0]).dwMsgId == 0x321);
    EXPECT(canChannelReadMessage(channel[0], 1, &message), VCI_E_TIMEOUT);
    EXPECT(canChannelPeekMessage(channel[0], &message), VCI_E_RXQUEUE_EMPTY);
    EXPECT(canChannelWaitRxEvent(channel[0], 1), VCI_E_TIMEOUT);
    OK(canChannelWaitTxEvent(channel[0], 1000));

    EXPECT(canControlStart(channel[0], TRUE), VCI_E_INVHANDLE);
    EXPECT(canControlStart((HANDLE)0x77, TRUE), VCI_E_INVHANDLE);
    EXPECT(canControlOpen(device[0], 99, &devices), VCI_E_INVALIDARG);
    EXPECT(canChannelReadMessage(channel[0], 0, NULL), VCI_E_INVALIDARG);
    EXPECT(canControlOpen(device[0], 0, &devices), VCI_E_ACCESSDENIED);
    OK(canSchedulerOpen(device[0], 0, &devices));
    EXPECT(canSchedulerStartMessage(devices, 0, 1), VCI_E_INVALID_INDEX);
    EXPECT(canSchedulerAddMessage(devices, NULL, &index), VCI_E_INVALIDARG);
    OK(linMonitorOpen(device[0], 0, FALSE, &monitor));
    OK(linMonitorInitialize(monitor, 100, 1));
    OK(linMonitorClose(monitor));
    close_under_readers();
    OK(canChannelClose(channel[0]));
    EXPECT(canChannelClose(channel[0]), VCI_E_INVHANDLE);
    puts("the flat interface");
    return 0;
}
