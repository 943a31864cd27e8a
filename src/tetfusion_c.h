/* TetFusion for C, and for languages that can call it: the same as tetfusion.h, which says more of
 * each thing. A tetrahedral mesh in memory goes in, a smaller one comes out.
 *
 *   tetfusion_mesh mesh = {0};
 *   mesh.points = (tetfusion_values){TETFUSION_FLOAT64, coordinates, 3 * point_count};
 *   mesh.connectivity = (tetfusion_values){TETFUSION_INT64, corners, 4 * tet_count};
 *   tetfusion_result* result = tetfusion_simplify(&mesh, "{\"reduction\": 0.9}", NULL);
 *   if (tetfusion_code(result) == 0) use(tetfusion_mesh_of(result));
 *   tetfusion_free(result);
 *
 * Texts end with a zero byte and are UTF-8 (names of arrays may be any other bytes). Pointers to
 * nothing are null. All functions may be called from any thread, and from several at once. */
#ifndef TETFUSION_C_H
#define TETFUSION_C_H

#include <stdint.h>

#define TETFUSION_C_PUBLIC __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

enum {
  TETFUSION_INT8 = 0,
  TETFUSION_UINT8 = 1,
  TETFUSION_INT16 = 2,
  TETFUSION_UINT16 = 3,
  TETFUSION_INT32 = 4,
  TETFUSION_UINT32 = 5,
  TETFUSION_INT64 = 6,
  TETFUSION_UINT64 = 7,
  TETFUSION_FLOAT32 = 8,
  TETFUSION_FLOAT64 = 9
};

typedef struct {
  int32_t type; /* one of these */
  const void* data;
  uint64_t size; /* numbers, not tuples */
} tetfusion_values;

typedef struct {
  const char* name;
  uint32_t components;
  tetfusion_values values; /* tuples over the points or cells of a mesh */
} tetfusion_array;

/* What goes in, which must not change meanwhile, and what comes out; members are those of
 * tetfusion::Mesh. */
typedef struct {
  tetfusion_values points;
  tetfusion_values connectivity;
  tetfusion_values offsets; /* of a mesh of tetrahedra alone none, and no types */
  tetfusion_values types;   /* TETFUSION_UINT8 */
  tetfusion_values ghosts;  /* TETFUSION_UINT8 */
  const tetfusion_array* point_arrays;
  uint64_t point_array_count;
  const tetfusion_array* cell_arrays;
  uint64_t cell_array_count;
  const char* active_scalars;
} tetfusion_mesh;

/* Each may be null. They are called from the thread that has called tetfusion_simplify(), with
 * `data`, and must not throw or jump out. */
typedef struct {
  void* data;
  void (*progress)(void* data, double share, const char* phase);
  int32_t (*cancelled)(void* data); /* anything but 0 ends the run */
  void (*notice)(void* data, const char* sentence);
} tetfusion_observer;

typedef struct tetfusion_result tetfusion_result;

/* `options` is a JSON object, or null for defaults: members of tetfusion::Options by their names,
 * null standing for the default. Enumerations are "fuse", "tetfuse"; "exact", "planar", "within".
 * Infinity is "inf". `arrays` is a list of {"name": "p", "of_cells": false, "tolerance": 0.01}.
 * `observer` may be null. Returns null where there is no memory for a result; it is freed with
 * tetfusion_free(). */
TETFUSION_C_PUBLIC tetfusion_result* tetfusion_simplify(const tetfusion_mesh* mesh,
                                                        const char* options,
                                                        const tetfusion_observer* observer);

/* What is returned lives as long as the result. */
/* The exit code that the command has for the same; 0: done. */
TETFUSION_C_PUBLIC int32_t tetfusion_code(const tetfusion_result* result);
/* What, where, and what to do; empty when all is well. */
TETFUSION_C_PUBLIC const char* tetfusion_message(const tetfusion_result* result);
/* JSON, as the command writes it with --report; empty where there is no mesh. */
TETFUSION_C_PUBLIC const char* tetfusion_report(const tetfusion_result* result);
/* With code 0, or 6 (a goal that was not reached, with the option `strict`); else it is empty. Its
 * first cells are the tetrahedra. */
TETFUSION_C_PUBLIC const tetfusion_mesh* tetfusion_mesh_of(const tetfusion_result* result);

TETFUSION_C_PUBLIC void tetfusion_free(tetfusion_result* result); /* may be null */

TETFUSION_C_PUBLIC const char* tetfusion_version(void); /* "0.1.0" */

#ifdef __cplusplus
}
#endif

#endif
