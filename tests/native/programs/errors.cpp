/* Bad input: every mistake gives the vendor's error code. */
#include "vci.h"

#include <errno.h>
#include <process.h>
#ifndef _WIN32
#include <sys/wait.h>
#include <unistd.h>
#endif

static void null_pointers(Line &line)
{
    EXPECT(VciGetVersion(NULL), VCI_E_INVALIDARG);
    EXPECT(VciGetDeviceManager(NULL), VCI_E_INVALIDARG);
    EXPECT(VciCreateLuid(NULL), VCI_E_INVALIDARG);
    EXPECT(line.layer->GetFeatures(NULL), VCI_E_INVALIDARG);
    EXPECT(line.layer->QueryInterface(IID_IUnknown, NULL), VCI_E_INVALIDARG);
    EXPECT(line.control->InitLine(NULL), VCI_E_INVALIDARG);
    EXPECT(line.control->DetectBaud(10, NULL), VCI_E_INVALIDARG);
    EXPECT(line.writer->PutDataEntry(NULL), VCI_E_INVALIDARG);
    EXPECT(line.writer->AcquireWrite(NULL, NULL), VCI_E_INVALIDARG);
    EXPECT(line.reader->GetCapacity(NULL), VCI_E_INVALIDARG);
}

static void texts()
{
    char text[64], small[8];
    VCIID id = {{1, 2}}, back;
    GUID guid;

    OK(VciLuidToChar(id, text, 17));
    TRUE_THAT(strcmp(text, "0000000200000001") == 0);
    EXPECT(VciLuidToChar(id, small, sizeof small), VCI_E_BUFFER_OVERFLOW);
    OK(VciCharToLuid(text, &back));
    TRUE_THAT(back.AsInt64 == id.AsInt64);
    EXPECT(VciCharToLuid((PCHAR) "no", &back), VCI_E_FAIL);
    OK(VciGuidToChar(IID_IBalObject, text, 39));
    TRUE_THAT(strcmp(text, "{A2B958AA-9188-4CDB-8307-25D9F1F843E9}") == 0);
    OK(VciCharToGuid(text, &guid));
    TRUE_THAT(guid == IID_IBalObject);
    EXPECT(VciGuidToChar(guid, text, 38), VCI_E_BUFFER_OVERFLOW);
    OK(VciFormatError(VCI_E_TIMEOUT, text, sizeof text));
    TRUE_THAT(strncmp(text, "VCI_E_TIMEOUT", 13) == 0);
    OK(VciFormatError(VCI_E_TIMEOUT, small, sizeof small));
    TRUE_THAT(strlen(small) == 7);
}

static void interfaces(Line &line)
{
    PVOID found = &line;
    UINT16 count;
    CANMSG message = {};
    PCANMSG block;

    EXPECT(line.layer->QueryInterface(IID_ICanChannel, &found), VCI_E_NOINTERFACE);
    TRUE_THAT(found == NULL);
    EXPECT(line.layer->OpenSocket(99, IID_ICanSocket, &found), VCI_E_INVALID_INDEX);
    EXPECT(line.layer->OpenSocket(0, IID_ICanControl, &found), VCI_E_ACCESSDENIED); /* one at a time */
    EXPECT(line.channel->GetReader((IFifoReader **)&found), VCI_E_ACCESSDENIED);
    EXPECT(line.reader->AssignEvent((HANDLE)0x1234), VCI_E_INVHANDLE);
    while (line.reader->GetDataEntry(&message) == VCI_OK)
        ;
    EXPECT(line.reader->AcquireRead((PVOID *)&block, &count), VCI_E_RXQUEUE_EMPTY);
    EXPECT(line.reader->ReleaseRead(1), VCI_E_INVALIDARG);
    message = {};
    message.uMsgInfo.Bits.edl = 1;
    EXPECT(line.writer->PutDataEntry(&message), VCI_E_INVALIDARG); /* a CANMSG has none */
    TRUE_THAT(line.layer->AddRef() == 2 && line.layer->Release() == 1);
    OK(line.reader->QueryInterface(IID_IVciFifo, &found));
    OK(static_cast<IVciFifo *>(found)->GetCapacity(&count));
    TRUE_THAT(count >= 4000);
    static_cast<IVciFifo *>(found)->Release();
    OK(line.channel->Initialize(100, 100));
    EXPECT(line.reader->GetDataEntry(&message), VCI_E_INVHANDLE); /* of the queue before */
    line.reader->Release();
    EXPECT(line.reader->GetDataEntry(&message), VCI_E_INVHANDLE);
    TRUE_THAT(line.reader->Release() == 0);
    OK(line.channel->GetReader(&line.reader));
    OK(line.channel->Activate());
}

#ifndef _WIN32
static void fork_of(Line &line)
{
    CANMSG message = {};
    int status;
    pid_t child = fork();

    if (child == 0) {
        EXPECT(line.reader->GetDataEntry(&message), VCI_E_DISCONNECTED);
        EXPECT(line.control->StopLine(), VCI_E_DISCONNECTED);
        Line own(1); /* with a connection of its own */
        own.control->StopLine();
        _exit(0);
    }
    TRUE_THAT(waitpid(child, &status, 0) == child && status == 0);
    OK(line.control->StopLine()); /* the parent's is as it was */
    errno = 0;
    TRUE_THAT(wait(NULL) == -1 && errno == ECHILD); /* nobody of ours is a child of the program's */
}

#endif

static volatile LONG done;

static unsigned __stdcall ask_often(void *layer)
{
    BALFEATURES features;

    for (int k = 0; k < 50; k++)
        OK(static_cast<IBalObject *>(layer)->GetFeatures(&features));
    InterlockedIncrement(&done);
    return 7;
}

static void threads(Line &line)
{
    HANDLE each[4];
    DWORD code;

    for (HANDLE &thread : each)
        TRUE_THAT((thread = (HANDLE)_beginthreadex(NULL, 0, ask_often, line.layer, 0, NULL)) != NULL);
    TRUE_THAT(WaitForMultipleObjects(4, each, TRUE, INFINITE) == WAIT_OBJECT_0);
    TRUE_THAT(GetExitCodeThread(each[0], &code) && code == 7 && done == 4);
    for (HANDLE thread : each)
        TRUE_THAT(CloseHandle(thread) && !CloseHandle(thread));
    TRUE_THAT(GetLastError() == ERROR_INVALID_HANDLE);
}

static unsigned __stdcall read_until_it_is_released(void *reader)
{
    CANMSG message;
    HRESULT result;

    do
        result = static_cast<IFifoReader *>(reader)->GetDataEntry(&message);
    while (result == VCI_OK || result == VCI_E_RXQUEUE_EMPTY);
    return result == static_cast<HRESULT>(VCI_E_INVHANDLE) ? 0 : 1;
}

/* A reader that is released while others use it: they hear of it, and its memory is not theirs any longer. */
static void released_meanwhile(Line &line)
{
    DWORD code;

    for (int round = 0; round < 20; round++) {
        HANDLE each[3];
        IFifoReader *reader;
        ICanChannel *channel;
        ICanSocket *socket;

        OK(line.layer->OpenSocket(0, IID_ICanSocket, (PVOID *)&socket));
        OK(socket->CreateChannel(FALSE, &channel));
        OK(channel->Initialize(50, 50));
        OK(channel->GetReader(&reader));
        for (HANDLE &thread : each)
            thread = (HANDLE)_beginthreadex(NULL, 0, read_until_it_is_released, reader, 0, NULL);
        TRUE_THAT(reader->Release() == 0);
        for (HANDLE thread : each) {
            TRUE_THAT(WaitForSingleObject(thread, 10000) == WAIT_OBJECT_0 && GetExitCodeThread(thread, &code) && code == 0);
            CloseHandle(thread);
        }
        channel->Release();
        socket->Release();
    }
}

static Line *kept;
static volatile LONG asked;

static unsigned __stdcall ask_at_the_end(void *)
{
    BALFEATURES features;

    while (kept->layer->GetFeatures(&features) == VCI_OK)
        InterlockedIncrement(&asked);
    return 0;
}

/* The program is on its way out, and a thread of it still asks. */
static void at_exit()
{
    CANMSG message;

    while (kept->reader->GetDataEntry(&message) == VCI_OK)
        ;
    if (asked == 0 || kept->control->StopLine() != VCI_OK || kept->reader->Release() != 0 ||
        kept->reader->GetDataEntry(&message) != static_cast<HRESULT>(VCI_E_INVHANDLE)) {
        fputs("at exit: not as before\n", stderr);
        _exit(1);
    }
}

static void until_the_end()
{
    kept = new Line(0, 1);
    TRUE_THAT(_beginthreadex(NULL, 0, ask_at_the_end, NULL, 0, NULL) != 0);
    while (asked == 0)
        Sleep(1);
    atexit(at_exit);
}

int main()
{
    Line line(0);

    null_pointers(line);
    texts();
    interfaces(line);
    threads(line);
    released_meanwhile(line);
#ifndef _WIN32
    fork_of(line);
#endif
    until_the_end();
    puts("every mistake has its code");
    return 0;
}
