/* Reads by the flat interface, with a timeout that is the hub's time, until nothing has come for so long. */
#include <stdio.h>
#include <windows.h>
#include <vcinpl.h>

int main(void)
{
    HANDLE boards, board, control, channel;
    VCIDEVICEINFO info;
    CANMSG message;

    if (vciInitialize() != VCI_OK || vciEnumDeviceOpen(&boards) != VCI_OK || vciEnumDeviceNext(boards, &info) != VCI_OK ||
        vciDeviceOpen(&info.VciObjectId, &board) != VCI_OK || canChannelOpen(board, 1, FALSE, &channel) != VCI_OK ||
        canChannelInitialize(channel, 100, 1, 100, 1) != VCI_OK || canChannelActivate(channel, TRUE) != VCI_OK ||
        canControlOpen(board, 1, &control) != VCI_OK ||
        canControlInitialize(control, CAN_OPMODE_STANDARD, CAN_BT01_500KB) != VCI_OK ||
        canControlStart(control, TRUE) != VCI_OK)
        return 1;
    while (canChannelReadMessage(channel, 60, &message) == VCI_OK)
        if (message.uMsgInfo.Bytes.bType == CAN_MSGTYPE_DATA && message.dwMsgId == 0x101)
            printf("%u ", message.abData[0]);
    printf("until %u\n", (unsigned)GetTickCount());
    return 0;
}
