#include "call.h"

Call::Call(const char *kind, const char *method, Remote object) : object_(object)
{
    snprintf(name_, sizeof name_, *kind ? "vci.%s.%s" : "vci.%s%s", kind, method);
    memset(&call_, 0, sizeof call_);
    call_.method = name_;
    call_.object = object.number;
    call_.in = in_;
}

Call::~Call()
{
    cw_close_descriptors(&call_);
}

Call &Call::bytes(const void *data, size_t size)
{
    if (call_.in_size + size <= sizeof in_) {
        memcpy(in_ + call_.in_size, data, size);
        call_.in_size += size;
    }
    return *this;
}

HRESULT Call::ask(void *out, size_t size)
{
    call_.out = out;
    call_.out_size = size;
    if (object_.process != cw_process() || cw_call(&call_) < 0)
        return VCI_E_DISCONNECTED;
    return call_.result;
}
