/* Libraries by Windows' names: "vciapi.dll" is libvciapi.so beside this one. */
#include "windows_core.h"

#include <dlfcn.h>
#include <limits.h>

static const char *const ours[] = {"vciapi", "vcinpl", "vcinpl2", "acan", "candrv"};

static HMODULE beside(const char *name)
{
    char path[PATH_MAX];
    Dl_info about;
    char *end;

    if (dladdr((void *)&beside, &about) == 0 || strlen(about.dli_fname) + 32 > sizeof path)
        return NULL;
    strcpy(path, about.dli_fname);
    end = strrchr(path, '/');
    sprintf(end != NULL ? end + 1 : path, "lib%s.so", name);
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}

HMODULE LoadLibraryA(LPCSTR name)
{
    HMODULE found = NULL;
    const char *last;
    size_t length;

    if (name == NULL) {
        cw_fail(ERROR_INVALID_PARAMETER);
        return NULL;
    }
    last = strrchr(name, '\\') != NULL ? strrchr(name, '\\') + 1 : name;
    length = strcspn(last, ".");
    for (size_t k = 0; k < ARRAYSIZE(ours); k++)
        if (strlen(ours[k]) == length && strncasecmp(ours[k], last, length) == 0)
            found = beside(ours[k]);
    if (found == NULL)
        found = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    if (found == NULL)
        cw_fail(ERROR_MOD_NOT_FOUND);
    return found;
}

HMODULE LoadLibraryW(LPCWSTR name)
{
    char narrow[PATH_MAX];

    if (name == NULL || wcstombs(narrow, name, sizeof narrow) >= sizeof narrow) {
        cw_fail(ERROR_INVALID_PARAMETER);
        return NULL;
    }
    return LoadLibraryA(narrow);
}

FARPROC GetProcAddress(HMODULE library, LPCSTR name)
{
    void *found = library != NULL && name != NULL ? dlsym(library, name) : NULL;

    if (found == NULL)
        cw_fail(ERROR_PROC_NOT_FOUND);
    return (FARPROC)found;
}

BOOL FreeLibrary(HMODULE library)
{
    return library != NULL && dlclose(library) == 0 ? TRUE : cw_fail(ERROR_INVALID_HANDLE);
}

void OutputDebugStringA(LPCSTR text)
{
    if (text != NULL)
        fputs(text, stderr);
}

int MessageBoxA(HWND above, LPCSTR text, LPCSTR caption, UINT kind)
{
    (void)above, (void)kind;
    fprintf(stderr, "%s: %s\n", caption != NULL ? caption : "Error", text != NULL ? text : "");
    return IDOK;
}
