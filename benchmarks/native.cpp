/* What benchmarks/native.py measures in C++: argv[1] says which. */
#include <vcisdk.h>

#include <algorithm>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <vector>

static const UINT16 ROOM = 4000;
static const unsigned FRAMES = 3000000, SINGLE = 1000000, ROUNDS = 20000, CALLS = 5000;

static double now()
{
    struct timespec time;

    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec + time.tv_nsec * 1e-9;
}

static void check(HRESULT result, const char *what)
{
    if (result != VCI_OK) {
        fprintf(stderr, "%s: %08X\n", what, result);
        exit(1);
    }
}
#define OK(what) check(what, #what)

template <class End> static End *access(VCIID id, REFIID iid, HANDLE event)
{
    PVOID end;

    OK(VciInitialize());
    OK(VciAccessFifo(id, iid, &end));
    if (event != NULL)
        OK(static_cast<End *>(end)->AssignEvent(event));
    return static_cast<End *>(end);
}

static void write_frames(IFifoWriter *writer, unsigned count, bool batches)
{
    HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
    CANMSG2 message = {};

    writer->AssignEvent(event);
    message.uMsgInfo.Bits.dlc = 8;
    for (unsigned k = 0; k < count;) {
        CANMSG2 *cells;
        UINT16 room;
        HRESULT result = batches ? writer->AcquireWrite((PVOID *)&cells, &room) : writer->PutDataEntry(&message);
        if (result != VCI_OK) {
            WaitForSingleObject(event, 10);
            continue;
        }
        if (!batches) {
            message.dwMsgId = ++k;
            continue; /* the first one had 0 */
        }
        room = (UINT16)std::min<unsigned>(std::min<unsigned>(room, 256), count - k);
        for (UINT16 at = 0; at < room; at++) {
            cells[at] = message;
            cells[at].dwMsgId = k++;
        }
        writer->ReleaseWrite(room);
    }
    while (true) { /* the reader has all of it before this end goes */
        UINT16 there;
        if (writer->GetFreeCount(&there) != VCI_OK || there >= ROOM)
            return;
        Sleep(1);
    }
}

/* For a reader of another program: its FIFO's number and how many frames are the words behind. */
static void write_to(char **words)
{
    VCIID id;

    id.AsInt64 = atoll(words[0]);
    OK(VciInitialize());
    write_frames(access<IFifoWriter>(id, IID_IFifoWriter, NULL), (unsigned)atol(words[1]), true);
}

static void in_order(const CANMSG2 &message, unsigned number)
{
    if (message.dwMsgId != number) {
        fprintf(stderr, "frame %u came in the place of %u\n", message.dwMsgId, number);
        exit(1);
    }
}

static void frames(unsigned count, bool batches)
{
    VCIID id;
    PVOID fifo;
    unsigned got = 0;

    OK(VciInitialize());
    OK(VciCreateFifo(&id, ROOM, sizeof(CANMSG2), IID_IVciFifo2, &fifo));
    HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
    IFifoReader *reader = access<IFifoReader>(id, IID_IFifoReader, event);
    pid_t child = fork();
    if (child == 0) {
        write_frames(access<IFifoWriter>(id, IID_IFifoWriter, NULL), count, batches);
        _exit(0);
    }
    double begun = 0;
    while (got < count) {
        CANMSG2 *cells, one;
        UINT16 there;
        if (batches && reader->AcquireRead((PVOID *)&cells, &there) == VCI_OK) {
            for (UINT16 at = 0; at < there; at++)
                in_order(cells[at], got++);
            reader->ReleaseRead(there);
        } else if (!batches && reader->GetDataEntry(&one) == VCI_OK) {
            in_order(one, got++);
        } else {
            WaitForSingleObject(event, 10);
            continue;
        }
        if (begun == 0)
            begun = now();
    }
    printf("C++    %-8s %6.2f M frames/s\n", batches ? "batches" : "single", count / (now() - begun) / 1e6);
    waitpid(child, NULL, 0);
}

static void one_way()
{
    VCIID there, back;
    PVOID one, other;
    std::vector<double> spans;

    OK(VciInitialize());
    OK(VciCreateFifo(&there, 100, sizeof(CANMSG2), IID_IVciFifo2, &one));
    OK(VciCreateFifo(&back, 100, sizeof(CANMSG2), IID_IVciFifo2, &other));
    pid_t child = fork();
    HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
    IFifoReader *reader = access<IFifoReader>(child ? back : there, IID_IFifoReader, event);
    IFifoWriter *writer = access<IFifoWriter>(child ? there : back, IID_IFifoWriter, NULL);
    CANMSG2 message = {};
    for (unsigned k = 0; k < ROUNDS; k++) {
        double begun = now();
        if (child)
            OK(writer->PutDataEntry(&message));
        while (reader->GetDataEntry(&message) != VCI_OK)
            WaitForSingleObject(event, child ? 1000 : 5000);
        if (!child)
            OK(writer->PutDataEntry(&message));
        spans.push_back((now() - begun) / 2);
    }
    if (!child)
        _exit(0);
    std::sort(spans.begin(), spans.end());
    printf("C++    one way  %6.1f us (median), %.1f (99 %%)\n", spans[ROUNDS / 2] * 1e6, spans[ROUNDS * 99 / 100] * 1e6);
    waitpid(child, NULL, 0);
}

static void socket_pair()
{
    int ends[2];
    CANMSG2 message = {};

    socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends);
    if (fork() == 0) {
        for (unsigned k = 0; k < SINGLE; k++)
            if (write(ends[1], &message, sizeof message) < 0)
                _exit(1);
        _exit(0);
    }
    double begun = now();
    for (unsigned k = 0; k < SINGLE; k++)
        if (read(ends[0], &message, sizeof message) < 0)
            exit(1);
    printf("socket single   %6.2f M frames/s\n", SINGLE / (now() - begun) / 1e6);
    wait(NULL);
}

static void calls()
{
    IVciDeviceManager *manager;
    IVciEnumDevice *devices;
    VCIDEVICEINFO info;
    IVciDevice *device;
    VCIDEVICECAPS capabilities;

    OK(VciGetDeviceManager(&manager));
    OK(manager->EnumDevices(&devices));
    OK(devices->Next(1, &info, NULL));
    OK(manager->OpenDevice(info.VciObjectId, &device));
    double begun = now();
    for (unsigned k = 0; k < CALLS; k++)
        OK(devices->Reset());
    double helper = now() - begun;
    begun = now();
    for (unsigned k = 0; k < CALLS; k++)
        OK(device->GetDeviceCaps(&capabilities));
    printf("C++    a call   %6.1f us, one that asks the hub %.1f us\n", helper / CALLS * 1e6, (now() - begun) / CALLS * 1e6);
}

static void start()
{
    double begun = now();

    OK(VciInitialize());
    double initialised = now();
    VCIID id;
    PVOID fifo, reader, writer;
    CANMSG2 message = {};
    OK(VciCreateFifo(&id, 100, sizeof message, IID_IVciFifo2, &fifo));
    OK(VciAccessFifo(id, IID_IFifoWriter, &writer));
    OK(VciAccessFifo(id, IID_IFifoReader, &reader));
    OK(static_cast<IFifoWriter *>(writer)->PutDataEntry(&message));
    OK(static_cast<IFifoReader *>(reader)->GetDataEntry(&message));
    printf("C++    start    %6.0f ms to the first frame, of which VciInitialize %.0f\n", (now() - begun) * 1e3,
           (initialised - begun) * 1e3);
}

int main(int, char **words)
{
    const char *what = words[1];

    setvbuf(stdout, NULL, _IONBF, 0);
    if (!strcmp(what, "start"))
        start();
    else if (!strcmp(what, "call"))
        calls();
    else if (!strcmp(what, "batches"))
        frames(FRAMES, true);
    else if (!strcmp(what, "single"))
        frames(SINGLE, false);
    else if (!strcmp(what, "write"))
        write_to(words + 2);
    else if (!strcmp(what, "one-way"))
        one_way();
    else
        socket_pair();
    return 0;
}
