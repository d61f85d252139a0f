/* The same by the flat interface (vcinpl.h). docs/native.md says how it is built. */
#include <stdio.h>
#include <vcinpl.h>

int main(void)
{
    HANDLE device, control, channel;
    CANMSG message = {0};

    if (vciDeviceOpenDlg(NULL, &device) != VCI_OK) /* the first one: there is no dialog */
        return 1;
    canChannelOpen(device, 0, FALSE, &channel);
    canChannelInitialize(channel, 100, 1, 100, 1);
    canChannelActivate(channel, TRUE);
    if (canControlOpen(device, 0, &control) == VCI_OK) {
        canControlInitialize(control, CAN_OPMODE_STANDARD, CAN_BT01_500KB);
        canControlStart(control, TRUE);
    }

    message.dwMsgId = 0x321;
    message.uMsgInfo.Bits.dlc = 1;
    message.uMsgInfo.Bits.srr = 1;
    message.abData[0] = 0x5A;
    canChannelSendMessage(channel, 1000, &message);
    while (canChannelReadMessage(channel, 5000, &message) == VCI_OK)
        if (message.uMsgInfo.Bytes.bType == CAN_MSGTYPE_DATA) {
            printf("%03X %02X\n", message.dwMsgId, message.abData[0]);
            return 0;
        }
    return 1;
}
