/* A first program for VCI V4: the first board sends a frame and hears it itself. docs/native.md says how it is built. */
#include <stdio.h>
#include <vcisdk.h>

int main()
{
    IVciDeviceManager *manager;
    IVciEnumDevice *devices;
    IVciDevice *device;
    IBalObject *layer;
    ICanSocket *socket;
    ICanChannel *channel;
    ICanControl *control;
    IFifoReader *reader;
    IFifoWriter *writer;
    VCIDEVICEINFO info;
    CANINITLINE init = {CAN_OPMODE_STANDARD, 0, CAN_BT01_500KB};
    CANMSG message = {};

    if (VciInitialize() != VCI_OK || VciGetDeviceManager(&manager) != VCI_OK)
        return 1; /* no hub */
    manager->EnumDevices(&devices);
    devices->Next(1, &info, NULL);
    manager->OpenDevice(info.VciObjectId, &device);
    device->OpenComponent(CLSID_VCIBAL, IID_IBalObject, (PVOID *)&layer);
    layer->OpenSocket(0, IID_ICanSocket, (PVOID *)&socket);
    socket->CreateChannel(FALSE, &channel);
    channel->Initialize(100, 100);
    channel->GetReader(&reader);
    channel->GetWriter(&writer);
    channel->Activate();
    if (layer->OpenSocket(0, IID_ICanControl, (PVOID *)&control) == VCI_OK) { /* else another program set the line up */
        control->InitLine(&init);
        control->StartLine();
    }

    HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
    reader->AssignEvent(event);
    message.dwMsgId = 0x123;
    message.uMsgInfo.Bits.dlc = 2;
    message.uMsgInfo.Bits.srr = 1; /* this channel hears it, too */
    message.abData[0] = 0xCA;
    message.abData[1] = 0xFE;
    writer->PutDataEntry(&message);
    while (WaitForSingleObject(event, 5000) == WAIT_OBJECT_0)
        while (reader->GetDataEntry(&message) == VCI_OK)
            if (message.uMsgInfo.Bytes.bType == CAN_MSGTYPE_DATA) {
                printf("%s: %03X %02X%02X\n", info.Description, message.dwMsgId, message.abData[0], message.abData[1]);
                return 0;
            }
    return 1;
}
