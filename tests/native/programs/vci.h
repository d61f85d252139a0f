/* What the programs of these tests share: a check that names what failed, and boards that are set up. */
#ifndef TESTS_VCI_H
#define TESTS_VCI_H
#include <vcisdk.h>

#include <stdio.h>
#include <stdlib.h>

#define EXPECT(result, code)                                                                                           \
    do {                                                                                                               \
        HRESULT got_ = (result);                                                                                       \
        if (got_ != (code)) {                                                                                          \
            fprintf(stderr, "%s:%d: %s is %08X, not %08X\n", __FILE__, __LINE__, #result, got_, code);                 \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)
#define OK(result) EXPECT(result, VCI_OK)
#define TRUE_THAT(what)                                                                                                \
    do {                                                                                                               \
        if (!(what)) {                                                                                                 \
            fprintf(stderr, "%s:%d: not %s\n", __FILE__, __LINE__, #what);                                             \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

#ifdef __cplusplus
struct Line {
    IBalObject *layer;
    ICanChannel *channel;
    ICanControl *control;
    IFifoReader *reader;
    IFifoWriter *writer;

    // The first CAN connector of board number `board`, at 500 kbit/s, started.
    explicit Line(unsigned board, UINT32 connector = 0)
    {
        IVciDeviceManager *manager;
        IVciEnumDevice *devices;
        IVciDevice *device;
        ICanSocket *socket;
        VCIDEVICEINFO info;
        CANINITLINE init = {CAN_OPMODE_STANDARD | CAN_OPMODE_EXTENDED, 0, CAN_BT01_500KB};

        OK(VciInitialize());
        OK(VciGetDeviceManager(&manager));
        OK(manager->EnumDevices(&devices));
        OK(devices->Skip(board));
        OK(devices->Next(1, &info, NULL));
        OK(manager->OpenDevice(info.VciObjectId, &device));
        OK(device->OpenComponent(CLSID_VCIBAL, IID_IBalObject, (PVOID *)&layer));
        OK(layer->OpenSocket(connector, IID_ICanSocket, (PVOID *)&socket));
        OK(socket->CreateChannel(FALSE, &channel));
        OK(channel->Initialize(4000, 4000));
        OK(channel->GetReader(&reader));
        OK(channel->GetWriter(&writer));
        OK(channel->Activate());
        OK(layer->OpenSocket(connector, IID_ICanControl, (PVOID *)&control));
        OK(control->InitLine(&init));
        OK(control->StartLine());
        devices->Release();
        manager->Release();
        device->Release();
        socket->Release();
    }

    ~Line()
    {
        reader->Release();
        writer->Release();
        channel->Release();
        control->Release();
        layer->Release();
    }

    // The next data frame, at the latest in ten seconds.
    CANMSG next()
    {
        HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
        CANMSG message;

        OK(reader->AssignEvent(event));
        do
            while (reader->GetDataEntry(&message) == VCI_OK)
                if (message.uMsgInfo.Bytes.bType == CAN_MSGTYPE_DATA) {
                    OK(reader->AssignEvent(NULL));
                    CloseHandle(event);
                    return message;
                }
        while (WaitForSingleObject(event, 10000) == WAIT_OBJECT_0);
        fprintf(stderr, "no frame came\n");
        exit(1);
    }
};
#endif
#endif
