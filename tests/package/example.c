/* A tetrahedron, as C has it. */
#include <stdio.h>
#include <tetfusion_c.h>

int main(void) {
  const float points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const int32_t corners[] = {0, 1, 2, 3};
  const double height[] = {0, 0, 0, 1};
  const tetfusion_array arrays[] = {{"height", 1, {TETFUSION_FLOAT64, height, 4}}};
  tetfusion_mesh mesh = {0};
  mesh.points = (tetfusion_values){TETFUSION_FLOAT32, points, 12};
  mesh.connectivity = (tetfusion_values){TETFUSION_INT32, corners, 4};
  mesh.point_arrays = arrays;
  mesh.point_array_count = 1;
  tetfusion_result* result = tetfusion_simplify(&mesh, "{\"reduction\": 0}", NULL);
  if (result == NULL || tetfusion_code(result) != 0) {
    fprintf(stderr, "%s\n", result == NULL ? "no memory" : tetfusion_message(result));
    return 1;
  }
  const tetfusion_mesh* out = tetfusion_mesh_of(result);
  printf("tetfusion %s in C: %d tetrahedron with %s\n", tetfusion_version(),
         (int)(out->connectivity.size / 4), out->point_arrays[0].name);
  tetfusion_free(result);
  return 0;
}
