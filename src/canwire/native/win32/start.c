/* Starting the helper: a process of Python's, which calls back over TCP and shows that it knows a token.
 *
 * The token goes with its environment, which nobody but this user reads. Under Wine it may be Linux' Python, too.
 */
#include "win32.h"

#include <errno.h>
#include <ntsecapi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <wchar.h>

#define PROGRAM L"from canwire.native.helper.main import main; main()" /* -m would load runpy, too */
#define TOKEN_NAME L"CANWIRE_PROGRAM_TOKEN"
#define PATIENCE_MS 60000 /* a helper that has not called by then never will */
#define UNSEEN_MS 20000   /* the same where nothing tells that it has ended: a process of the system below Wine */
#define PYTHON_SIZE 1024
#define LINE_SIZE 4096

struct hello { /* what the helper says first: ../helper/far.py */
    unsigned char token[TOKEN_SIZE];
    uint16_t port; /* where it hears of more connections */
};

static int under_wine(void)
{
    return GetProcAddress(GetModuleHandleW(L"ntdll.dll"), "wine_get_version") != NULL;
}

/* CANWIRE_PYTHON, else the first in PATH; under Wine that of the system below, whose env finds it. */
static const wchar_t *find_python(wchar_t *python)
{
    DWORD size = GetEnvironmentVariableW(L"CANWIRE_PYTHON", python, PYTHON_SIZE);

    if (size > 0 && size < PYTHON_SIZE)
        return L"";
    wcscpy(python, under_wine() ? L"/usr/bin/env" : L"python.exe");
    return under_wine() ? L"python3 " : L"";
}

/* "/usr/bin/python3" as Wine starts it; any other path, or a name to be found in PATH, as it is. */
static void file_of(const wchar_t *python, wchar_t *file)
{
    if (python[0] != L'/') {
        wcscpy(file, python);
        return;
    }
    wcscpy(file, L"\\\\?\\unix");
    wcscat(file, python);
    for (wchar_t *at = file; *at != L'\0'; at++)
        if (*at == L'/')
            *at = L'\\';
}

static void name_of_program(wchar_t *name)
{
    wchar_t path[MAX_PATH] = L"";
    const wchar_t *last;

    GetModuleFileNameW(NULL, path, MAX_PATH - 1);
    last = wcsrchr(path, L'\\');
    wcscpy(name, last != NULL ? last + 1 : path);
}

static void command_line(wchar_t *line, wchar_t *file, uint16_t port)
{
    wchar_t python[PYTHON_SIZE], name[MAX_PATH];
    const wchar_t *first = find_python(python);

    file_of(python, file);
    name_of_program(name);
    swprintf(line, LINE_SIZE, L"\"%ls\" %ls-P -c \"" PROGRAM L"\" %lu \"%ls\" %u", python, first, GetCurrentProcessId(),
             name, port); /* as it was named: Python finds its environment by that */
}

/* This process's environment, and the token besides: TOKEN_NAME=64 digits. NULL: no memory. */
static wchar_t *environment_with(const unsigned char *token)
{
    wchar_t *own = GetEnvironmentStringsW(), *made, *at;
    size_t size = 0;

    if (own == NULL)
        return NULL;
    while (own[size] != L'\0')
        size += wcslen(own + size) + 1;
    made = calloc(size + wcslen(TOKEN_NAME) + 2 * TOKEN_SIZE + 8, sizeof *made);
    if (made != NULL) {
        memcpy(made, own, size * sizeof *made);
        at = made + size;
        at += swprintf(at, 64, TOKEN_NAME L"=");
        for (int k = 0; k < TOKEN_SIZE; k++)
            at += swprintf(at, 3, L"%02x", token[k]);
    }
    FreeEnvironmentStringsW(own);
    return made;
}

/* The helper's process, or NULL where Wine started one of the system below; -1 with errno. */
static int run(wchar_t *file, wchar_t *line, wchar_t *environment, HANDLE *process)
{
    STARTUPINFOW how = {.cb = sizeof how};
    PROCESS_INFORMATION made = {0};
    const wchar_t *application = wcschr(file, L'\\') != NULL ? file : NULL; /* a name alone is looked for */

    if (!CreateProcessW(application, line, NULL, NULL, FALSE,
                        CREATE_UNICODE_ENVIRONMENT | CREATE_NEW_PROCESS_GROUP | CREATE_NO_WINDOW, environment, NULL, &how,
                        &made)) {
        errno = ENOENT;
        return -1;
    }
    if (made.hThread != NULL)
        CloseHandle(made.hThread);
    *process = made.hProcess;
    return 0;
}

static SOCKET new_listener(uint16_t *port)
{
    struct sockaddr_in where = {.sin_family = AF_INET};
    int size = sizeof where;
    SOCKET made = far_socket();
    DWORD exclusive = 1;

    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (made == INVALID_SOCKET)
        return made;
    setsockopt(made, SOL_SOCKET, SO_EXCLUSIVEADDRUSE, (const char *)&exclusive, sizeof exclusive);
    if (bind(made, (struct sockaddr *)&where, sizeof where) != 0 || listen(made, 8) != 0 ||
        getsockname(made, (struct sockaddr *)&where, &size) != 0) {
        closesocket(made);
        errno = EADDRNOTAVAIL;
        return INVALID_SOCKET;
    }
    *port = ntohs(where.sin_port);
    return made;
}

/* 1: somebody calls; 0: not in time, or the helper has ended before it did. */
static int called(SOCKET listener, HANDLE process)
{
    HANDLE both[2] = {WSACreateEvent(), process};
    DWORD found;

    if (both[0] == NULL || WSAEventSelect(listener, both[0], FD_ACCEPT) != 0)
        return 0;
    found = WaitForMultipleObjects(process != NULL ? 2 : 1, both, FALSE,
                                   process != NULL ? PATIENCE_MS : UNSEEN_MS);
    WSAEventSelect(listener, NULL, 0);
    WSACloseEvent(both[0]);
    return found == WAIT_OBJECT_0;
}

static int same(const unsigned char *one, const unsigned char *other) /* in a time that tells nothing */
{
    unsigned char different = 0;

    for (int k = 0; k < TOKEN_SIZE; k++)
        different |= one[k] ^ other[k];
    return different == 0;
}

/* Strangers who call first are turned away. */
static int accept_helper(SOCKET listener, HANDLE process, struct far_helper *helper)
{
    DWORD now = 1, patience = PATIENCE_MS;
    u_long blocking = 0;
    struct hello hello;

    while (called(listener, process)) {
        SOCKET caller = accept(listener, NULL, NULL);
        if (caller == INVALID_SOCKET)
            continue;
        WSAEventSelect(caller, NULL, 0); /* it inherits the listener's */
        ioctlsocket(caller, FIONBIO, &blocking);
        SetHandleInformation((HANDLE)caller, HANDLE_FLAG_INHERIT, 0);
        setsockopt(caller, SOL_SOCKET, SO_RCVTIMEO, (const char *)&patience, sizeof patience);
        if (far_receive(caller, hello.token, TOKEN_SIZE) == 0 && same(hello.token, helper->token) &&
            far_receive(caller, &hello.port, sizeof hello.port) == 0) {
            patience = 0; /* for ever */
            setsockopt(caller, SOL_SOCKET, SO_RCVTIMEO, (const char *)&patience, sizeof patience);
            setsockopt(caller, IPPROTO_TCP, TCP_NODELAY, (const char *)&now, sizeof now);
            helper->lifeline = caller;
            helper->port = hello.port;
            return 0;
        }
        closesocket(caller);
    }
    errno = ENOTCONN;
    return -1;
}

static int begin(SOCKET listener, uint16_t port, struct far_helper *helper)
{
    wchar_t file[PYTHON_SIZE + 16], line[LINE_SIZE];
    wchar_t *environment;
    HANDLE process = NULL;
    int begun;

    if (!RtlGenRandom(helper->token, TOKEN_SIZE) || (environment = environment_with(helper->token)) == NULL) {
        errno = ENOMEM;
        return -1;
    }
    command_line(line, file, port);
    begun = run(file, line, environment, &process);
    free(environment);
    if (begun == 0)
        begun = accept_helper(listener, process, helper);
    if (process != NULL)
        CloseHandle(process);
    return begun;
}

int far_start(struct far_helper *helper)
{
    uint16_t port = 0;
    SOCKET listener;
    int begun;

    if (far_sockets_ready() < 0)
        return -1;
    listener = new_listener(&port);
    if (listener == INVALID_SOCKET)
        return -1;
    begun = begin(listener, port, helper);
    closesocket(listener);
    return begun;
}
