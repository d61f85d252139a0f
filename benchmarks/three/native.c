/* A program in C on VCI's flat interface: the board with the serial number argv[1]; a line for each frame of data. */
#include <vcinpl.h>

#include <stdio.h>
#include <string.h>

static int fails(const char *what, HRESULT result)
{
    if (result != VCI_OK)
        fprintf(stderr, "%s: %08X\n", what, result);
    return result != VCI_OK;
}

int main(int count, char **words)
{
    HANDLE devices, device, channel, control;
    VCIDEVICEINFO info;
    CANMSG message;
    HRESULT result;

    if (count != 2 || fails("vciInitialize", vciInitialize()) || fails("vciEnumDeviceOpen", vciEnumDeviceOpen(&devices)))
        return 3;
    do {
        if (fails("vciEnumDeviceNext", vciEnumDeviceNext(devices, &info)))
            return 3;
    } while (strncmp(info.UniqueHardwareId.AsChar, words[1], strlen(words[1])) != 0);
    if (fails("vciDeviceOpen", vciDeviceOpen(&info.VciObjectId, &device))
        || fails("canChannelOpen", canChannelOpen(device, 0, FALSE, &channel))
        || fails("canChannelInitialize", canChannelInitialize(channel, 256, 1, 16, 1))
        || fails("canChannelActivate", canChannelActivate(channel, TRUE))
        || fails("canControlOpen", canControlOpen(device, 0, &control))
        || fails("canControlInitialize", canControlInitialize(control, CAN_OPMODE_STANDARD, CAN_BT01_500KB))
        || fails("canControlStart", canControlStart(control, TRUE)))
        return 3;
    for (;;) {
        result = canChannelReadMessage(channel, 200, &message);
        if (result == VCI_E_TIMEOUT || result == VCI_E_RXQUEUE_EMPTY)
            continue;
        if (fails("canChannelReadMessage", result))
            return 3;
        if (message.uMsgInfo.Bytes.bType != CAN_MSGTYPE_DATA)
            continue;
        printf("%X%s#", message.dwMsgId, message.uMsgInfo.Bits.ovr ? "!" : "");
        for (unsigned k = 0; k < message.uMsgInfo.Bits.dlc; k++)
            printf("%02X", message.abData[k]);
        puts("");
        fflush(stdout);
    }
}
