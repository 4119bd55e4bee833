// The component dart: the shared library is found, at link time and at run time.
#include <cstdio>
#include <saltus/robots/dart/dart_plant.hpp>

int main(int argc, char**) {
  if (argc > 100) saltus::robots::make_dart_plant({}, {});
  std::puts("linked with libsaltus_dart");
}
