/* A program for VCI V4 on Windows: it sends 321 every 20 ms, says once it has heard 123 and 456, and ends with its input. */
#include <vcisdk.h>

#include <stdio.h>
#include <string.h>

#define OK(result)                                                                                                     \
    do {                                                                                                               \
        HRESULT got_ = (result);                                                                                       \
        if (got_ != VCI_OK) {                                                                                          \
            printf("line %d: %s is %08lX\n", __LINE__, #result, got_);                                                 \
            return 1;                                                                                                  \
        }                                                                                                              \
    } while (0)

static IBalObject *first_layer()
{
    IVciDeviceManager *manager;
    IVciEnumDevice *devices;
    IVciDevice *device;
    IBalObject *layer = nullptr;
    VCIDEVICEINFO info;

    if (VciGetDeviceManager(&manager) != VCI_OK || manager->EnumDevices(&devices) != VCI_OK ||
        devices->Next(1, &info, nullptr) != VCI_OK || manager->OpenDevice(info.VciObjectId, &device) != VCI_OK ||
        device->OpenComponent(CLSID_VCIBAL, IID_IBalObject, (PVOID *)&layer) != VCI_OK)
        return nullptr;
    return layer;
}

static bool hear(IFifoReader *reader, HANDLE event)
{
    bool heard_123 = false, heard_456 = false;
    CANMSG message;

    while (!(heard_123 && heard_456)) {
        if (WaitForSingleObject(event, 60000) != WAIT_OBJECT_0)
            return false;
        while (reader->GetDataEntry(&message) == VCI_OK) {
            heard_123 |= message.dwMsgId == 0x123;
            heard_456 |= message.dwMsgId == 0x456;
        }
    }
    return true;
}

int main()
{
    HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
    CANINITLINE how = {CAN_OPMODE_STANDARD, 0, CAN_BT0_500KB, CAN_BT1_500KB};
    CANCYCLICTXMSG cyclic = {};
    IBalObject *layer = first_layer();
    ICanSocket *socket;
    ICanChannel *channel;
    ICanControl *control;
    ICanScheduler *scheduler;
    IFifoReader *reader;
    CANCAPABILITIES able;
    UINT32 number;

    if (layer == nullptr)
        return 1;
    OK(layer->OpenSocket(0, IID_ICanSocket, (PVOID *)&socket));
    OK(socket->GetCapabilities(&able));
    OK(socket->CreateChannel(FALSE, &channel));
    OK(channel->Initialize(1024, 16));
    OK(channel->GetReader(&reader));
    OK(reader->AssignEvent(event));
    OK(channel->Activate());
    OK(layer->OpenSocket(0, IID_ICanControl, (PVOID *)&control));
    OK(control->InitLine(&how));
    OK(control->SetAccFilter(CAN_FILTER_STD, CAN_ACC_CODE_ALL, CAN_ACC_MASK_ALL));
    OK(control->StartLine());
    OK(layer->OpenSocket(0, IID_ICanScheduler, (PVOID *)&scheduler));
    cyclic.wCycleTime = (UINT16)(able.dwClockFreq / able.dwCmsDivisor / 50);
    cyclic.dwMsgId = 0x321;
    cyclic.uMsgInfo.Bits.dlc = 1;
    cyclic.abData[0] = 0x5A;
    OK(scheduler->AddMessage(&cyclic, &number));
    OK(scheduler->Resume());
    OK(scheduler->StartMessage(number, 0));
    puts("sending");
    fflush(stdout);
    if (!hear(reader, event)) {
        puts("one was not heard");
        return 1;
    }
    puts("heard 123 and 456");
    fflush(stdout);
    while (getchar() != EOF)
        ;
    return 0;
}
