/* Many frames through the rings: all arrive in order; where the reader is too slow, the channel says so. */
#include "vci.h"

static const unsigned FRAMES = 2500;

static void send(Line &line, unsigned number)
{
    HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
    CANMSG message = {};
    HRESULT result;

    OK(line.writer->AssignEvent(event));
    message.dwMsgId = 0x100;
    message.uMsgInfo.Bits.dlc = 4;
    memcpy(message.abData, &number, sizeof number);
    while ((result = line.writer->PutDataEntry(&message)) == VCI_E_TXQUEUE_FULL)
        TRUE_THAT(WaitForSingleObject(event, 10000) == WAIT_OBJECT_0);
    OK(result);
    OK(line.writer->AssignEvent(NULL));
    CloseHandle(event);
}

int main()
{
    Line sender(0), receiver(1);
    CANCHANSTATUS status;
    UINT16 capacity;

    for (unsigned number = 0; number < FRAMES; number++)
        send(sender, number);
    for (unsigned number = 0; number < FRAMES; number++) {
        CANMSG message = receiver.next();
        unsigned got;

        memcpy(&got, message.abData, sizeof got);
        TRUE_THAT(got == number);
    }
    OK(receiver.channel->GetStatus(&status));
    TRUE_THAT(status.fActivated && !status.fRxOverrun);

    receiver.reader->Release(); /* a small queue that nobody reads */
    receiver.writer->Release();
    OK(receiver.channel->Initialize(1, 1));
    OK(receiver.channel->GetReader(&receiver.reader));
    OK(receiver.channel->GetWriter(&receiver.writer));
    OK(receiver.channel->Activate());
    OK(receiver.reader->GetCapacity(&capacity));
    HANDLE full = CreateEvent(NULL, FALSE, FALSE, NULL);
    OK(receiver.reader->SetThreshold(capacity));
    OK(receiver.reader->AssignEvent(full));
    for (unsigned number = 0; number < capacity + 10u; number++)
        send(sender, number);
    TRUE_THAT(WaitForSingleObject(full, 10000) == WAIT_OBJECT_0);
    do
        OK(receiver.channel->GetStatus(&status));
    while (!status.fRxOverrun);
    TRUE_THAT(status.bRxFifoLoad == 100);
    printf("%u in order\n", FRAMES);
    return 0;
}
