/* The manual's listings, as printed (VCI V4 manual, 4.1.1, 4.1.2, 5.2.3 and 5.3.2), on a bus.
 *
 * Lines of three dots, which stand for the reader's own code, are left out when they are built.
 */
#include "vci.h"

#include <initializer_list>
#include <process.h>

namespace messages {
#include "manual_receive.inc"
#include "manual_transmit.inc"
}
namespace blocks {
#include "manual_receive_blocks.inc"
#define sCanMsg2 (*pCanMsg2) /* the listing has two names for one message */
#include "manual_transmit_in_place.inc"
#undef sCanMsg2
}
namespace line {
#include "manual_auto_init.inc"
}
namespace lin {
#include "manual_lin.inc"
}
namespace lin_blocks {
#include "manual_lin_blocks.inc"
}

static volatile LONG enough;

static unsigned talk(void *writer)
{
    for (; !enough; Sleep(1))
        messages::TransmitByte(static_cast<IFifoWriter *>(writer), 0x100, 0);
    return 0;
}

static UINT16 waiting(IFifoReader *reader)
{
    UINT16 count;

    OK(reader->GetFillCount(&count));
    return count;
}

static void lin_messages(IBalObject *layer)
{
    LININITLINE init = {LIN_OPMODE_MASTER, 0, LIN_BITRATE_19200};
    LINMSG message = {};
    ILinSocket *socket;
    ILinMonitor *monitor;
    ILinControl *control;
    IFifoReader *reader;

    OK(layer->OpenSocket(2, IID_ILinSocket, (PVOID *)&socket));
    OK(socket->CreateMonitor(FALSE, &monitor));
    OK(monitor->Initialize(100));
    OK(monitor->GetReader(&reader));
    OK(monitor->Activate());
    OK(layer->OpenSocket(2, IID_ILinControl, (PVOID *)&control));
    OK(control->InitLine(&init));
    OK(control->StartLine());
    message.uMsgInfo.Bits.pid = 0x11;
    message.uMsgInfo.Bits.dlen = 2;
    message.abData[1] = 0x77;
    OK(control->WriteMessage(TRUE, &message));
    HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
    OK(reader->AssignEvent(event));
    for (message = {}; message.uMsgInfo.Bits.type != LIN_MSGTYPE_DATA || message.uMsgInfo.Bits.dlen != 2;)
        if (reader->GetDataEntry(&message) != VCI_OK)
            TRUE_THAT(WaitForSingleObject(event, 10000) == WAIT_OBJECT_0);
    TRUE_THAT((message.uMsgInfo.Bits.pid & LIN_PIDMASK_ID) == 0x11 && message.abData[1] == 0x77);
    while (reader->GetDataEntry(&message) == VCI_OK)
        ;
    for (auto listing : {lin::DoMessages, lin_blocks::DoMessages}) {
        OK(control->StopLine()); /* which tells of itself */
        OK(control->StartLine());
        TRUE_THAT(WaitForSingleObject(event, 10000) == WAIT_OBJECT_0 && waiting(reader) > 0);
        listing(reader);
        TRUE_THAT(waiting(reader) == 0);
    }
}

int main()
{
    Line sender(0), other(0, 1), receiver(1);
    CANMSG message;

    TRUE_THAT(messages::TransmitByte(sender.writer, 0x123, 0xA5));
    message = receiver.next();
    TRUE_THAT(message.dwMsgId == 0x123 && message.uMsgInfo.Bits.dlc == 1 && message.abData[0] == 0xA5);

    TRUE_THAT(messages::TransmitByte(sender.writer, 0x124, 1));
    receiver.next();
    messages::ReceiveMessages(receiver.reader);
    TRUE_THAT(waiting(receiver.reader) == 0);

    OK(receiver.control->ResetLine()); /* and finds the rate of what the others say */
    HANDLE talking = (HANDLE)_beginthreadex(NULL, 0, talk, sender.writer, 0, NULL);
    TRUE_THAT(line::AutoInitLine(receiver.control));
    InterlockedExchange(&enough, 1);
    WaitForSingleObject(talking, INFINITE);
    CANLINESTATUS status;
    OK(receiver.control->GetLineStatus(&status));
    TRUE_THAT(status.bBtReg0 == CAN_BT0_500KB && status.bBtReg1 == CAN_BT1_500KB);

    ICanSocket2 *socket; /* the listing with CANMSG2 reads a FIFO of those */
    ICanChannel2 *channel;
    IFifoReader *reader;
    OK(sender.layer->OpenSocket(0, IID_ICanSocket2, (PVOID *)&socket));
    OK(socket->CreateChannel(FALSE, &channel));
    OK(channel->Initialize(100, 100, 0, CAN_FILTER_PASS));
    OK(channel->GetReader(&reader));
    OK(channel->Activate());
    HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
    OK(reader->AssignEvent(event));
    TRUE_THAT(messages::TransmitByte(other.writer, 0x125, 2));
    TRUE_THAT(WaitForSingleObject(event, 10000) == WAIT_OBJECT_0 && waiting(reader) > 0);
    blocks::ReceiveMessages(reader);
    TRUE_THAT(waiting(reader) == 0);
    lin_messages(sender.layer);
    TRUE_THAT(&blocks::TransmitByte != NULL);
    puts("the listings did what they say");
    return 0;
}
