#include "worker.h"

static void *work(void *user)
{
    worker *own = user;
    worker_lock(own);
    while (!own->ending)
        if (!own->turn(own->user) && !own->ending) pthread_cond_wait(&own->more, &own->lock);
    worker_unlock(own);
    return NULL;
}

pith_status worker_start(worker *own, worker_turn *turn, void *user, const char *what_for, pith_error *err)
{
    *own = (worker){ .turn = turn, .user = user };
    pthread_mutex_init(&own->lock, NULL);
    pthread_cond_init(&own->more, NULL);
    if (pthread_create(&own->thread, NULL, work, own) == 0) return PITH_OK;
    pthread_cond_destroy(&own->more);
    pthread_mutex_destroy(&own->lock);
    return pith_fail(err, PITH_EXTERNAL, "no thread can be made for %s", what_for);
}

void worker_stop(worker *own)
{
    worker_lock(own);
    own->ending = true;
    worker_call(own);
    worker_unlock(own);
    pthread_join(own->thread, NULL);
    pthread_cond_destroy(&own->more);
    pthread_mutex_destroy(&own->lock);
}

void worker_lock(worker *own) { pthread_mutex_lock(&own->lock); }
void worker_unlock(worker *own) { pthread_mutex_unlock(&own->lock); }
void worker_call(worker *own) { pthread_cond_signal(&own->more); }
