/* A C program that loads a plugin and moves a cart by 1 m. The cart drags a brake of 0.1 m/s^2 that
 * the controller does not know, and every tenth measurement is lost.
 *
 * Usage: host PLUGIN */
#include <dlfcn.h>
#include <math.h>
#include <saltus/c/saltus_c.h>
#include <stdio.h>
#include <stdlib.h>

/* The functions that this host uses, and their names in the plugin. */
// clang-format off
#define FUNCTIONS(DO) \
  DO(saltus_interface_version) DO(saltus_create) DO(saltus_destroy) DO(saltus_error) \
  DO(saltus_read_sizes) DO(saltus_set_data) DO(saltus_prepare) DO(saltus_feedback) \
  DO(saltus_read_piece) DO(saltus_read_plan)
// clang-format on
#define MEMBER(name) __typeof__(&name) name;
static struct {
  FUNCTIONS(MEMBER)
} plugin;

static int load(const char* path) {
  void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (library == NULL) {
    fprintf(stderr, "host: %s\n", dlerror());
    return 0;
  }
#define FIND(name) *(void**)&plugin.name = dlsym(library, #name);
  FUNCTIONS(FIND)
#define FOUND(name) &&plugin.name != NULL
  return 1 FUNCTIONS(FOUND) && plugin.saltus_interface_version() == SALTUS_INTERFACE_VERSION;
}

static void check(saltus_status status, const saltus_controller* controller) {
  if (status == SALTUS_OK) return;
  fprintf(stderr, "host: %s\n", plugin.saltus_error(controller));
  exit(EXIT_FAILURE);
}

/* The cart during dt seconds. */
static void move(double* x, double u, double dt) {
  const int steps = 20;
  for (int i = 0; i < steps; ++i) {
    const double drag = 0.2 * x[1] * sqrt(x[1] * x[1] + 0.01);
    x[0] += dt / steps * x[1];
    x[1] += dt / steps * (u - drag - 0.1 * tanh(100.0 * x[1]));
  }
}

int main(int arguments, char** argument) {
  if (arguments != 2 || !load(argument[1])) {
    fprintf(stderr, "usage: host PLUGIN, a plugin for interface %d\n", SALTUS_INTERFACE_VERSION);
    return EXIT_FAILURE;
  }
  saltus_controller* cart = NULL;
  const saltus_status status = plugin.saltus_create("cart", &cart);
  check(status, cart);
  saltus_sizes sizes;
  check(plugin.saltus_read_sizes(cart, &sizes), cart);
  const double target = 1.0; /* m */
  check(plugin.saltus_set_data(cart, "target", &target, 1), cart);

  double x[2] = {0.0, 0.0}, largest = 0.0;
  int planned = 0, lost = 0;
  for (int k = 0; k < 200; ++k) {
    saltus_tick tick;
    check(plugin.saltus_prepare(cart, k * sizes.period), cart);
    check(plugin.saltus_feedback(cart, k % 10 == 9 ? NULL : x, sizes.states, &tick), cart);
    planned += tick.provenance == SALTUS_OPTIMAL;
    lost += tick.provenance == SALTUS_SHIFTED;
    for (int i = 0; i < tick.pieces; ++i) {
      double start, length, u[1];
      int count;
      check(plugin.saltus_read_piece(cart, i, &start, &length, u, 1, &count), cart);
      if (fabs(u[0]) > largest) largest = fabs(u[0]);
      move(x, u[0], length);
    }
  }

  double times[64], states[64][2], inputs[64][1];
  int rows;
  check(plugin.saltus_read_plan(cart, times, NULL, states[0], inputs[0], 64, &rows), cart);
  printf("%d ticks with an optimum, %d without a measurement\n", planned, lost);
  printf("%.2f m from the target, largest input %.2f m/s^2\n", fabs(x[0] - target), largest);
  printf("the last plan has %d nodes and takes %.2f s\n", rows, times[rows - 1] - times[0]);
  plugin.saltus_destroy(cart);
  return fabs(x[0] - target) < 0.05 ? EXIT_SUCCESS : EXIT_FAILURE;
}
