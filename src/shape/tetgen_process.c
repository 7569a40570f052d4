/* Running the helper program pith-tetgen: start, talk, watch the clock, reap.

   posix_spawn and not fork, because the caller may hold OpenMP or TBB threads. One socket pair and not two pipes: a
   socket takes MSG_NOSIGNAL, so that a helper that dies while it is written to costs no SIGPIPE, and one poll serves
   both directions. */
#include "tets_internal.h"
#include "tetgen_protocol.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

extern char **environ;

/* ---- finding the program --------------------------------------------------------------------------------------- */

static bool runs(const char *path)
{
    return access(path, X_OK) == 0;
}

pith_status pith_tetgen_find(char *path, size_t capacity, pith_error *err)
{
    static const char name[] = "pith-tetgen";
    char self[PATH_MAX];
    const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    self[length > 0 ? length : 0] = 0;
    for (int up = 0; up < 2; ++up) { /* the program's folder, then the one above */
        char *slash = strrchr(self, '/');
        if (!slash) break;
        *slash = 0;
        if ((size_t)snprintf(path, capacity, "%s/%s", self, name) < capacity && runs(path)) return PITH_OK;
    }
    const char *folder = getenv("PITH_LIBEXEC");
    if (folder && (size_t)snprintf(path, capacity, "%s/%s", folder, name) < capacity && runs(path)) return PITH_OK;
#ifdef PITH_TETGEN_BUILD_PATH
    if ((size_t)snprintf(path, capacity, "%s", PITH_TETGEN_BUILD_PATH) < capacity && runs(path)) return PITH_OK;
#endif
    return pith_fail(err, PITH_EXTERNAL,
                     "the mesher program pith-tetgen is neither beside this program nor in PITH_LIBEXEC (%s); put it "
                     "there or set PITH_LIBEXEC to its folder",
                     folder ? folder : "not set");
}

/* ---- a running helper ------------------------------------------------------------------------------------------ */

typedef struct helper {
    pid_t pid;
    int socket;
    double deadline;                /* pith_seconds */
    double started, time_limit, memory_limit;
    const pith_progress *progress;
} helper;

static pith_status start(const char *program, const pith_tetgen_job *job, helper *h, pith_error *err)
{
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return pith_fail(err, PITH_EXTERNAL, "the mesher cannot be started: %s", strerror(errno));
    fcntl(ends[0], F_SETFL, O_NONBLOCK);

    /* The helper starts with no signal blocked or ignored, the socket as its input, and its prints going nowhere. */
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t signals;
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 0);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    sigemptyset(&signals);
    posix_spawnattr_setsigmask(&attributes, &signals);
    sigfillset(&signals);
    posix_spawnattr_setsigdefault(&attributes, &signals);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

    char *arguments[] = { (char *)(uintptr_t)program, NULL };
    const int failure = posix_spawn(&h->pid, program, &actions, &attributes, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    close(ends[1]);
    if (failure != 0) {
        close(ends[0]);
        return pith_fail(err, PITH_EXTERNAL, "the mesher %s cannot be started: %s", program, strerror(failure));
    }
    h->socket = ends[0];
    h->started = pith_seconds();
    h->time_limit = job->time_limit;
    h->memory_limit = job->memory_limit;
    h->deadline = h->started + job->time_limit;
    return PITH_OK;
}

/* Ends the helper if it still lives, and reaps it. `patient` waits up to a second for a helper that is ending by
   itself, so that its own way of dying is seen. Returns its wait status, or -1 when that is unknown. */
static int finish(helper *h, bool patient)
{
    int how = -1;
    close(h->socket);
    for (int tries = patient ? 200 : 0; tries > 0; --tries) {
        const pid_t got = waitpid(h->pid, &how, WNOHANG);
        if (got == h->pid) return how;
        if (got < 0 && errno != EINTR) return -1; /* somebody ignores or reaps all children of this process */
        const struct timespec pause = { 0, 5000000 };
        nanosleep(&pause, NULL);
    }
    kill(h->pid, SIGKILL);
    pid_t got;
    do got = waitpid(h->pid, &how, 0);
    while (got < 0 && errno == EINTR);
    return got == h->pid ? how : -1;
}

/* The sentence for a helper that ended without a full reply. */
static pith_status explain_death(const helper *h, int how, pith_error *err)
{
    if (how >= 0 && WIFSIGNALED(how) && WTERMSIG(how) == SIGXCPU)
        return pith_fail(err, PITH_EXTERNAL, "TetGen used up its %g seconds; raise time_limit or ask for fewer "
                         "tetrahedra", h->time_limit);
    if (how >= 0 && WIFSIGNALED(how))
        return pith_fail(err, PITH_EXTERNAL, "TetGen died of signal %d (%s) after %.1f s; the surface may be too "
                         "entangled for it, or memory_limit (%g MiB) too low", WTERMSIG(how),
                         strsignal(WTERMSIG(how)), pith_seconds() - h->started, h->memory_limit);
    return pith_fail(err, PITH_EXTERNAL, "TetGen ended without an answer (exit status %d); memory_limit (%g MiB) may "
                     "be too low", how >= 0 && WIFEXITED(how) ? WEXITSTATUS(how) : -1, h->memory_limit);
}

/* Waits until the socket is ready for `events`, reporting progress ten times a second. */
static pith_status wait_ready(helper *h, short events, pith_error *err)
{
    for (;;) {
        const double left = h->deadline - pith_seconds();
        if (!(left > 0.0))
            return pith_fail(err, PITH_EXTERNAL, "TetGen took longer than %g seconds; raise time_limit or ask for "
                             "fewer tetrahedra", h->time_limit);
        struct pollfd waited = { .fd = h->socket, .events = events };
        const int ready = poll(&waited, 1, left < 0.1 ? (int)(left * 1000.0) + 1 : 100);
        if (ready > 0) return PITH_OK;
        if (ready < 0 && errno != EINTR)
            return pith_fail(err, PITH_EXTERNAL, "waiting for TetGen failed: %s", strerror(errno));
        /* Nobody knows how far TetGen is; time against the limit at least moves. */
        const double fraction = (pith_seconds() - h->started) / h->time_limit;
        PITH_TRY(pith_progress_step(h->progress, fraction < 1.0 ? fraction : 1.0, "filling with tetrahedra", err));
    }
}

/* Sends or receives all of it. *closed says that the other end is gone, whose reason is then asked of the process. */
static pith_status transfer(helper *h, void *data, size_t size, bool sending, bool *closed, pith_error *err)
{
    char *at = data;
    while (size > 0) {
        PITH_TRY(wait_ready(h, sending ? POLLOUT : POLLIN, err));
        const ssize_t moved = sending ? send(h->socket, at, size, MSG_NOSIGNAL) : recv(h->socket, at, size, 0);
        if (moved < 0 && (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK)) continue;
        if (moved <= 0) {
            *closed = true;
            return pith_fail(err, PITH_EXTERNAL, "TetGen closed the connection");
        }
        at += moved;
        size -= (size_t)moved;
    }
    return PITH_OK;
}

static pith_status send_part(helper *h, const void *data, size_t size, bool *closed, pith_error *err)
{
    return transfer(h, (void *)(uintptr_t)data, size, true, closed, err);
}

/* ---- one conversation ------------------------------------------------------------------------------------------ */

/* Points scaled by a power of two, which costs no bit either way: TetGen has absolute thresholds in places, and its
   switches no room for tiny volumes. */
static pith_vec3 *scaled_points(const pith_vec3 *points, size_t count, double scale)
{
    pith_vec3 *scaled = pith_alloc(count, sizeof *scaled);
    for (size_t i = 0; scaled && i < count; ++i) scaled[i] = pith_scale(points[i], scale);
    return scaled;
}

static pith_status send_request(helper *h, const pith_tetgen_job *job, double scale, bool *closed, pith_error *err)
{
    const pith_tetgen_request request = {
        .magic = PITH_TETGEN_MAGIC,
        .point_count = job->surface.vertex_count,
        .triangle_count = job->surface.triangle_count,
        .interior_count = (uint32_t)job->interior_count,
        .check_intersections = job->check_intersections,
        .radius_edge = job->radius_edge,
        .volume_bound = job->volume_bound * scale * scale * scale,
        .time_limit = job->time_limit,
        .memory_limit = job->memory_limit,
        .conform = job->sizes != NULL,
    };
    pith_vec3 *points = scaled_points(job->surface.positions, job->surface.vertex_count, scale);
    pith_vec3 *interior = scaled_points(job->interior, job->interior_count, scale);
    const size_t size_count = job->sizes ? job->surface.vertex_count : 0;
    double *sizes = pith_alloc(size_count, sizeof *sizes);
    pith_status status = PITH_OK;
    if (!points || !interior || !sizes) {
        status = PITH_OUT_OF_MEMORY(err, "what TetGen is sent");
        goto done;
    }
    for (size_t i = 0; i < size_count; ++i) sizes[i] = job->sizes[i] * scale;
    PITH_TRY_OR(done, send_part(h, &request, sizeof request, closed, err));
    PITH_TRY_OR(done, send_part(h, points, job->surface.vertex_count * sizeof *points, closed, err));
    PITH_TRY_OR(done, send_part(h, interior, job->interior_count * sizeof *interior, closed, err));
    PITH_TRY_OR(done, send_part(h, job->surface.triangles,
                                job->surface.triangle_count * sizeof *job->surface.triangles, closed, err));
    PITH_TRY_OR(done, send_part(h, sizes, size_count * sizeof *sizes, closed, err));
done:
    pith_free(points);
    pith_free(interior);
    pith_free(sizes);
    return status;
}

static pith_status check_reply(const pith_tetgen_reply *reply, const pith_tetgen_job *job, pith_error *err)
{
    if (reply->magic != PITH_TETGEN_MAGIC || reply->outcome > PITH_TETGEN_BAD_REQUEST)
        return pith_fail(err, PITH_EXTERNAL, "the mesher program answers in a language of its own; is pith-tetgen of "
                         "the same version as this program?");
    if (reply->outcome == PITH_TETGEN_BAD_REQUEST)
        return pith_fail(err, PITH_EXTERNAL, "the mesher program did not understand the request; is pith-tetgen of "
                         "the same version as this program?");
    if (reply->outcome == PITH_TETGEN_CROSSES)
        return pith_fail(err, PITH_BAD_MESH, "the surface crosses itself: TetGen finds %u triangles that meet others "
                         "where they must not", reply->crossing_count);
    if (reply->outcome == PITH_TETGEN_EMPTY || reply->tet_count == 0)
        return pith_fail(err, PITH_BAD_MESH, "TetGen made no tetrahedra; the surface encloses nothing");
    /* What the helper built lies within its memory limit; more is a lie that must not make us allocate. */
    const double bytes = 24.0 * reply->point_count + 16.0 * reply->tet_count;
    if (reply->point_count > PITH_TETGEN_MOST || reply->tet_count > PITH_TETGEN_MOST ||
        bytes > job->memory_limit * 1048576.0)
        return pith_fail(err, PITH_EXTERNAL, "the mesher program announces %u points and %u tetrahedra, more than its "
                         "memory limit can hold", reply->point_count, reply->tet_count);
    return PITH_OK;
}

/* The pieces of facets that a helper which was asked to conform sends last. */
static pith_status receive_faces(helper *h, const pith_tetgen_job *job, uint32_t point_count, bool *closed,
                                 pith_conforming *faces, pith_error *err)
{
    uint32_t count, (*records)[4];
    PITH_TRY(transfer(h, &count, sizeof count, false, closed, err));
    if (count > PITH_TETGEN_MOST || 16.0 * count > job->memory_limit * 1048576.0)
        return pith_fail(err, PITH_EXTERNAL,
                         "the mesher program announces %u faces, more than its memory limit can hold", count);
    records = pith_alloc(count, sizeof *records);
    faces->faces = pith_alloc(count, sizeof *faces->faces);
    faces->facet = pith_alloc(count, sizeof *faces->facet);
    faces->face_count = count;
    pith_status status = PITH_OK;
    if (!records || !faces->faces || !faces->facet) status = PITH_OUT_OF_MEMORY(err, "TetGen's faces");
    if (status == PITH_OK) status = transfer(h, records, count * sizeof *records, false, closed, err);
    for (uint32_t f = 0; status == PITH_OK && f < count; ++f) {
        const uint32_t *r = records[f];
        if (r[0] >= point_count || r[1] >= point_count || r[2] >= point_count || r[3] >= job->surface.triangle_count) {
            status = pith_fail(err, PITH_EXTERNAL,
                               "the mesher program gives face %u the vertices %u, %u and %u of %u, as a piece of "
                               "triangle %u of %u",
                               f, r[0], r[1], r[2], point_count, r[3], job->surface.triangle_count);
            break;
        }
        memcpy(faces->faces[f], r, sizeof faces->faces[f]);
        faces->facet[f] = r[3];
    }
    pith_free(records);
    return status;
}

/* faces: to conform, else NULL. */
static pith_status receive_reply(helper *h, const pith_tetgen_job *job, double scale, bool *closed, pith_tets **tets,
                                 pith_conforming *faces, pith_error *err)
{
    pith_tetgen_reply reply;
    PITH_TRY(transfer(h, &reply, sizeof reply, false, closed, err));
    PITH_TRY(check_reply(&reply, job, err));
    pith_vec3 *points = pith_alloc(reply.point_count, sizeof *points);
    uint32_t (*corners)[4] = pith_alloc(reply.tet_count, sizeof *corners);
    pith_status status = PITH_OK;
    if (!points || !corners) {
        status = PITH_OUT_OF_MEMORY(err, "TetGen's tetrahedra");
        goto fail;
    }
    PITH_TRY_OR(fail, transfer(h, points, reply.point_count * sizeof *points, false, closed, err));
    PITH_TRY_OR(fail, transfer(h, corners, reply.tet_count * sizeof *corners, false, closed, err));
    if (faces) PITH_TRY_OR(fail, receive_faces(h, job, reply.point_count, closed, faces, err));
    for (uint32_t i = 0; i < reply.point_count; ++i) points[i] = pith_scale(points[i], 1.0 / scale);

    /* The promise that surface vertices stay in place and in order is checked, not believed. */
    const size_t kept = job->surface.vertex_count * sizeof *points;
    if (reply.point_count < job->surface.vertex_count || memcmp(points, job->surface.positions, kept) != 0) {
        status = pith_fail(err, PITH_EXTERNAL, "TetGen moved or merged vertices of the surface; some lie too close "
                           "together");
        goto fail;
    }
    return pith_tets_adopt(points, reply.point_count, corners, reply.tet_count, tets, err);
fail:
    pith_free(points);
    pith_free(corners);
    return status;
}

static pith_status converse(const char *program, const pith_tetgen_job *job, const pith_progress *progress,
                            pith_tets **tets, pith_conforming *faces, pith_error *err)
{
    if (job->surface.vertex_count > PITH_TETGEN_MOST || job->surface.triangle_count > PITH_TETGEN_MOST ||
        job->interior_count > PITH_TETGEN_MOST)
        return pith_fail(err, PITH_BAD_MESH, "the surface has %u triangles, more than TetGen can count",
                         job->surface.triangle_count);
    const pith_box box = pith_box_of(job->surface.positions, job->surface.vertex_count);
    const pith_vec3 size = pith_sub(box.high, box.low);
    int exponent = 0;
    frexp(fmax(size.x, fmax(size.y, size.z)), &exponent);
    const double scale = ldexp(1.0, -exponent);
    if (!(scale > 0.0 && isfinite(scale) && isfinite(1.0 / scale)))
        return pith_fail(err, PITH_BAD_MESH, "the surface has no size that a mesher can work with");

    helper h = { .progress = progress };
    PITH_TRY(start(program, job, &h, err));
    bool closed = false;
    pith_status status = send_request(&h, job, scale, &closed, err);
    if (status == PITH_OK || closed) { /* a helper that hung up may have said why before */
        closed = false;
        status = receive_reply(&h, job, scale, &closed, tets, faces, err);
    }
    const int how = finish(&h, closed);
    return closed ? explain_death(&h, how, err) : status;
}

pith_status pith_tetgen_run(const char *program, const pith_tetgen_job *job, const pith_progress *progress,
                            pith_tets **tets, pith_error *err)
{
    pith_tets *made = NULL;
    const pith_status status = converse(program, job, progress, &made, NULL, err);
    if (status == PITH_OK) *tets = made;
    return status;
}

pith_status pith_tetgen_run_conform(const char *program, const pith_tetgen_job *job, const pith_progress *progress,
                                    pith_conforming *made, pith_error *err)
{
    pith_conforming got = { 0 };
    const pith_status status = converse(program, job, progress, &got.tets, &got, err);
    if (status == PITH_OK)
        *made = got;
    else
        pith_conforming_free(&got);
    return status;
}
