/* The exchange in C: for programs that are not Talik's own, in C, Fortran, Python, Julia and whatever else calls C.

   A law of one's own answers mpm-driver:              a driver of one's own asks rve-farm:
       talik_law law = {...};                              talik_driver* d = talik_driver_open("shm:name", &options);
       talik_serve("shm:name", &law, NULL, 60);            talik_driver_configure(d, "spec.toml", rves);
                                                           talik_driver_step(d, ...); ...
   beside: mpm-driver run SCENE --exchange shm:name        beside: rve-farm serve --exchange shm:name

   Every function returns 0, or the exit code that Talik's own programs end with for that fault (1 failed, 2 bad input,
   3 partner lost, 4 out of a resource); talik_last_error() then says what is wrong and what to do, in one line.
   Numbers are SI, stress and strain tension positive. Arrays of columns lie component by component: value c of row i of a
   batch of n rows is at [c * n + i]. A handle belongs to one thread at a time. The ABI is stable within a major
   version: structures only grow at their end, and carry their size. */
#ifndef TALIK_EXCHANGE_C_API_H
#define TALIK_EXCHANGE_C_API_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TALIK_API_VERSION 1
#if defined(__GNUC__)
#define TALIK_API __attribute__((visibility("default")))
#else
#define TALIK_API
#endif

TALIK_API const char* talik_version(void);      /* "0.1.0" */
TALIK_API int talik_api_version(void);          /* TALIK_API_VERSION of the library */
TALIK_API const char* talik_last_error(void);   /* of this thread; "" after no fault */

/* A quantity by name, with its number of components and its SI unit, "1" for a pure number. Talik's own are listed by
   talik_known_column(0), (1), ... until NULL: requests first, then answers. */
typedef struct talik_column {
    const char* name;
    int32_t components;
    const char* unit;
    const char* meaning; /* may be NULL */
} talik_column;
TALIK_API const talik_column* talik_known_column(int index);

/* ---- A law of one's own ------------------------------------------------------------------------------------------- */

/* What a law is told of the RVEs (points) it answers for; valid during `configure`. */
typedef struct talik_setup {
    size_t size;                  /* sizeof(talik_setup) of the library */
    size_t rves;
    const double* initial_stress; /* [3 * rves]: xx yy xy, of the packing that the scene gives each, Pa */
    double thickness;             /* m */
    double grain_density;         /* kg/m^3 */
    const double* void_ratio;     /* [rves], of these packings */
    const double* volume;         /* [rves], of these packings' cells, m^3: energies are of one such volume */
} talik_setup;

/* A chunk of a step. Columns come in the order in which the law named them. */
typedef struct talik_batch {
    size_t size;
    size_t rows;
    const uint32_t* ids;    /* [rows]: which RVEs, 0 .. rves - 1 */
    uint64_t step;          /* macro step, from 1 */
    double time_increment;  /* s */
    const double* request;  /* [components of all requested columns * rows] */
    double* answer;         /* [components of all answered columns * rows], to be filled */
} talik_batch;

/* Called in the thread of talik_serve(). Each returns 0, or an exit code after talik_set_error(). The law is asked for each step
   of an RVE once: requests that are sent again (after a restart, or a partner's death) the library answers from its memory. */
typedef struct talik_law {
    size_t size;                   /* sizeof(talik_law) */
    const char* name;              /* "Mohr-Coulomb in Python", for people */
    const talik_column* request;   /* columns that it reads; displacement_gradient_increment must be among them */
    size_t request_columns;
    const talik_column* answer;    /* columns that it gives; stress and stiffness must be among them. What else a driver asks */
    size_t answer_columns;         /* for is answered 0 where it is an energy, a count or a status, else as not known (NaN) */
    int (*configure)(void* user, const talik_setup* setup, double* initial); /* initial: [components * rves], the answers before the first step */
    int (*answer_batch)(void* user, const talik_batch* batch);
    int (*command)(void* user, const char* name);                           /* such as "activate bonds"; NULL = refused */
    int (*checkpoint)(void* user, const char* path);                        /* writes its state to that file; NULL = it has none */
    int (*restore)(void* user, const char* path);
} talik_law;
TALIK_API void talik_set_error(const char* text);

/* Joins the exchange ("shm:NAME" or "file:FOLDER"), waits for a driver at most attach_seconds, and answers it until it says bye. */
TALIK_API int talik_serve(const char* exchange, const talik_law* law, void* user, double attach_seconds);

/* ---- A driver of one's own ---------------------------------------------------------------------------------------- */

typedef struct talik_driver talik_driver;
typedef struct talik_driver_options {
    size_t size;                 /* sizeof(talik_driver_options) */
    const char* program;         /* for people */
    const talik_column* request; /* columns that it sends; displacement_gradient_increment must be among them */
    size_t request_columns;
    const talik_column* answer;  /* columns that it wants; stress and status must be among them */
    size_t answer_columns;
    double attach_seconds;       /* for the farm to come; 0 = 60 */
    double stall_seconds;        /* for a farm that does not move; 0 = 120 */
} talik_driver_options;

/* Opens the exchange and waits for a farm to join. talik_driver_close() is due in any case but NULL. */
TALIK_API int talik_driver_open(talik_driver** out, const char* exchange, const talik_driver_options* options);
/* RVEs from a specification in TOML with the tables [rve], [rve.packing], [rve.contact], [rve.bond] (as of `rve-farm element`),
   whose packing is a file; packings are dealt out in turn. initial: NULL, or [components of the answer * rves]. */
TALIK_API int talik_driver_configure(talik_driver* driver, const char* specification, size_t rves, double* initial);
/* One macro step of any subset of the RVEs. substeps: of the DEM; 0 = the farm decides. */
TALIK_API int talik_driver_step(talik_driver* driver, uint64_t step, double time_increment, uint32_t substeps, size_t rows, const uint32_t* ids,
                                const double* request, double* answer);
TALIK_API int talik_driver_command(talik_driver* driver, const char* name); /* "activate bonds" */
TALIK_API int talik_driver_checkpoint(talik_driver* driver, const char* path);
TALIK_API int talik_driver_restore(talik_driver* driver, const char* path);
/* s, of this side and of the farm: computing, copying, waiting (only the last of this side is known). */
TALIK_API int talik_driver_times(talik_driver* driver, double own_waiting[1], double farm[3]);
TALIK_API int talik_driver_bye(talik_driver* driver);    /* the farm ends in order */
TALIK_API void talik_driver_close(talik_driver* driver); /* without bye: the farm sees the driver leave */

#ifdef __cplusplus
}
#endif
#endif
