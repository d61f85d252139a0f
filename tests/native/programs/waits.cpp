/* What becomes of a program whose hub, or whose helper, is gone: it waits for a frame, and says what it is told. */
#include "vci.h"

int main()
{
    Line line(0);
    HANDLE event = CreateEvent(NULL, FALSE, FALSE, NULL);
    CANMSG message;
    HRESULT result;

    OK(line.reader->AssignEvent(event));
    while (line.reader->GetDataEntry(&message) == VCI_OK)
        ;
    puts("waiting");
    fflush(stdout);
    do {
        if (WaitForSingleObject(event, INFINITE) != WAIT_OBJECT_0)
            return 2;
        while ((result = line.reader->GetDataEntry(&message)) == VCI_OK)
            ;
    } while (result == VCI_E_RXQUEUE_EMPTY);
    EXPECT(line.control->StopLine(), VCI_E_DISCONNECTED);
    printf("%08X\n", result);
    return 0;
}
