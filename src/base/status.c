/* Status codes and the sentences that go with them. */
#include "pith/base.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

pith_status pith_fail(pith_error *err, pith_status status, const char *format, ...)
{
    if (err) {
        va_list arguments;
        va_start(arguments, format);
        err->status = status;
        vsnprintf(err->message, sizeof err->message, format, arguments);
        va_end(arguments);
    }
    return status;
}

pith_status pith_fail_in(pith_error *err, pith_status status, const char *context, ...)
{
    if (!err) return status;
    char old[sizeof err->message], head[sizeof err->message];
    memcpy(old, err->message, sizeof old);
    va_list arguments;
    va_start(arguments, context);
    vsnprintf(head, sizeof head, context, arguments);
    va_end(arguments);
    /* Long contexts give way to the message: the reason matters more than the path to it. */
    const size_t room = sizeof err->message - 3, need = strlen(old) < room ? strlen(old) : room;
    snprintf(err->message, sizeof err->message, "%.*s: %.*s", (int)(room - need), head, (int)need, old);
    return err->status;
}

const char *pith_status_text(pith_status status)
{
    switch (status) {
    case PITH_OK: return "ok";
    case PITH_BAD_ARGUMENT: return "bad argument";
    case PITH_BAD_FILE: return "bad file";
    case PITH_IO: return "input/output error";
    case PITH_BAD_MESH: return "bad mesh";
    case PITH_BAD_DOCUMENT: return "bad document";
    case PITH_NO_MEMORY: return "out of memory";
    case PITH_NOT_CONVERGED: return "not converged";
    case PITH_CANCELLED: return "cancelled";
    case PITH_EXTERNAL: return "external failure";
    }
    return "unknown status";
}
