/* Hashes of files, for the keys of stages. An editor makes a model after every edit, and a scan of some 50 MB takes a
   fifth of a second to read and hash: what was hashed and has not been touched since is not read again. */
#include <pthread.h>
#include <sys/stat.h>
#include <time.h>

#include "document_internal.h"

/* A file as it was, by all that the system says of it; ctime cannot be set back by those who write. */
typedef struct file_state {
    uint64_t device, inode, size;
    int64_t modified[2], changed[2];    /* seconds, nanoseconds */
} file_state;

/* Two writes within the clock's tick cannot be told apart: what was changed so recently is read again. The coarsest
   clock of a file system ticks every two seconds. */
enum { TICK = 3, REMEMBERED = 64 };

static struct memory {
    pthread_mutex_t lock;
    struct { file_state file; uint64_t seed, hash; } known[REMEMBERED];
    size_t next;                        /* the one that is forgotten next */
} memory = { .lock = PTHREAD_MUTEX_INITIALIZER };

/* False when nothing is known of it, or it has just been changed. */
static bool look_at(const char *path, file_state *state)
{
    struct stat s;
    if (stat(path, &s) != 0 || !S_ISREG(s.st_mode)) return false;
    *state = (file_state){ s.st_dev, s.st_ino, (uint64_t)s.st_size, { s.st_mtim.tv_sec, s.st_mtim.tv_nsec },
                           { s.st_ctim.tv_sec, s.st_ctim.tv_nsec } };
    const time_t now = time(NULL);
    return s.st_mtim.tv_sec + TICK <= now && s.st_ctim.tv_sec + TICK <= now;
}

static bool same_file(const file_state *a, const file_state *b)
{
    return a->device == b->device && a->inode == b->inode && a->size == b->size && a->modified[0] == b->modified[0] &&
           a->modified[1] == b->modified[1] && a->changed[0] == b->changed[0] && a->changed[1] == b->changed[1];
}

static bool recall(const file_state *file, uint64_t *hash)
{
    bool found = false;
    pthread_mutex_lock(&memory.lock);
    for (size_t i = 0; !found && i < REMEMBERED; ++i) {
        found = memory.known[i].seed == *hash && same_file(&memory.known[i].file, file);
        if (found) *hash = memory.known[i].hash;
    }
    pthread_mutex_unlock(&memory.lock);
    return found;
}

static void remember(const file_state *file, uint64_t seed, uint64_t hash)
{
    pthread_mutex_lock(&memory.lock);
    memory.known[memory.next].file = *file;
    memory.known[memory.next].seed = seed;
    memory.known[memory.next].hash = hash;
    memory.next = (memory.next + 1) % REMEMBERED;
    pthread_mutex_unlock(&memory.lock);
}

pith_status hash_file(const char *path, uint64_t *hash, pith_error *err)
{
    file_state before, after;
    const bool settled = look_at(path, &before);
    if (settled && recall(&before, hash)) return PITH_OK;
    unsigned char *bytes;
    size_t size;
    PITH_TRY(pith_file_read(path, &bytes, &size, err));
    const uint64_t seed = *hash;
    *hash = pith_hash_bytes(bytes, size, seed);
    pith_free(bytes);
    if (settled && look_at(path, &after) && same_file(&before, &after)) remember(&before, seed, *hash);
    return PITH_OK;
}
