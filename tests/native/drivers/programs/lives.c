/* Handles and task blocks when something ends: the hub, the helper, the process; and in forks. */
#include <windows.h>
#include <sys/wait.h>
#include <unistd.h>
#include "ACAN.H"
#include "canbusio.h"
#include "checks.h"

static HANDLE hCAN;
static struct {
    ACANTB block;
    ACANID any;
} task;
static ACANMB fifo[4], buffer[4];

static HANDLE Open(void)
{
    return CreateFile("CID1:", GENERIC_READ | GENERIC_WRITE, 3, NULL, OPEN_EXISTING, 0, NULL);
}

static BOOL Register(void)
{
    task.any.bAction = IDA_QUEUEMSG;
    task.block.lpRMB = fifo;
    task.block.wRMBSize = ARRAYSIZE(fifo);
    task.block.lpBuf = buffer;
    task.block.wCount = ARRAYSIZE(buffer);
    task.block.bNId = 1;
    return ACAN_Register(&task.block);
}

static void open_all(void)
{
    hCAN = Open();
    CHECK(hCAN != INVALID_HANDLE_VALUE);
    CHECK(ACAN_Init() == 0x0100 && Register());
}

static void all_fails(DWORD error)
{
    char text[100];
    DWORD count;
    COMMTIMEOUTS timeouts;
    ACANMB message = {0};
    ACANHI hi;

    FAILS(error, ReadFile(hCAN, text, sizeof text, &count, NULL));
    FAILS(error, WriteFile(hCAN, "1 0 0\n", 6, &count, NULL));
    FAILS(error, DeviceIoControl(hCAN, IOCTL_CAN_GET_BAUDRATE, NULL, 0, &count, sizeof count, NULL, NULL));
    FAILS(error, WaitCommEvent(hCAN, &count, NULL));
    CHECK(ACAN_GetDriverVersion() == 0 && ACAN_GetInitStatus() == 0 && !ACAN_GetHardConfig(&hi));
    CHECK(!ACAN_SendMessage(&message, 1) && ACAN_BusControl(BUS_ON) == 0);
    CHECK(ACAN_AckEventCheck(&task.block) == 0 && ACAN_RetrieveMessages(&task.block) == -1);
}

static void wait_for_the_test(void)
{
    puts("ready");
    fflush(stdout);
    CHECK(getchar() != EOF);
}

static void hub_ends(void)
{
    COMMTIMEOUTS timeouts = {0, 0, INFINITE, 0, INFINITE};
    char text[100];
    DWORD count;

    CHECK(SetCommTimeouts(hCAN, &timeouts));
    wait_for_the_test();
    FAILS(ERROR_DEV_NOT_EXIST, ReadFile(hCAN, text, sizeof text, &count, NULL)); /* once it is known here */
    while (ACAN_RetrieveMessages(&task.block) != -1) /* ACAN's own thread hears of it a moment later */
        Sleep(1);
    all_fails(ERROR_DEV_NOT_EXIST);
    CHECK(CloseHandle(hCAN));
    ACAN_Deregister(&task.block);
    ACAN_Exit();
}

static void helper_ends(void)
{
    wait_for_the_test();
    all_fails(ERROR_DEV_NOT_EXIST);
    CHECK(CloseHandle(hCAN));
    open_all(); /* another helper */
    CHECK(CloseHandle(hCAN) && ACAN_Deregister(&task.block));
}

static void fork_has_nothing(void)
{
    DWORD rate;
    int status;
    pid_t child = fork();

    if (child == 0) {
        all_fails(ERROR_INVALID_HANDLE);
        open_all(); /* a helper of its own */
        CHECK(ACAN_Deregister(&task.block));
        exit(0);
    }
    CHECK(waitpid(child, &status, 0) == child && status == 0);
    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_GET_BAUDRATE, NULL, 0, &rate, sizeof rate, NULL, NULL));
    CHECK(ACAN_Deregister(&task.block));
}

static DWORD CALLBACK read_for_ever(LPVOID name)
{
    char text[100];
    DWORD count;

    (void)name;
    for (;;)
        ReadFile(hCAN, text, sizeof text, &count, NULL);
    return 0;
}

static DWORD CALLBACK open_and_close(LPVOID name)
{
    char text[100];
    DWORD count;

    (void)name;
    for (int k = 0; k < 10; k++) {
        HANDLE mine;

        while ((mine = Open()) == INVALID_HANDLE_VALUE) {
            CHECK(GetLastError() == ERROR_NO_SYSTEM_RESOURCES); /* the others have all virtual channels */
            Sleep(1);
        }
        CHECK(GetCommMask(mine, &count) && CloseHandle(mine));
        FAILS(ERROR_INVALID_HANDLE, ReadFile(mine, text, sizeof text, &count, NULL));
    }
    return 0;
}

/* from many threads, while one of them waits; and main() returns while it still does */
static void threads(void)
{
    HANDLE all[4];
    COMMTIMEOUTS timeouts = {0, 0, INFINITE, 0, INFINITE};
    DWORD code;

    CHECK(SetCommTimeouts(hCAN, &timeouts) && CreateThread(NULL, 0, read_for_ever, NULL, 0, NULL) != NULL);
    for (int k = 0; k < 4; k++)
        CHECK((all[k] = CreateThread(NULL, 0, open_and_close, NULL, 0, NULL)) != NULL);
    CHECK(WaitForMultipleObjects(4, all, TRUE, INFINITE) == WAIT_OBJECT_0);
    for (int k = 0; k < 4; k++)
        CHECK(GetExitCodeThread(all[k], &code) && code == 0 && CloseHandle(all[k]));
}

int main(int argc, char **argv)
{
    CHECK(argc == 2);
    open_all();
    if (strcmp(argv[1], "hub") == 0)
        hub_ends();
    else if (strcmp(argv[1], "helper") == 0)
        helper_ends();
    else if (strcmp(argv[1], "fork") == 0)
        fork_has_nothing();
    else if (strcmp(argv[1], "threads") == 0)
        threads();
    else
        wait_for_the_test();
    puts("done");
    return 0;
}
