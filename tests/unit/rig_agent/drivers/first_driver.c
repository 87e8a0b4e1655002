/* The example driver as a library of version 1. */
#define tonus_driver_v2 spring_rig_v2
#include "examples/driver/spring_rig.c"

const tonus_driver_v1_table* tonus_driver_v1(void) {
  static tonus_driver_v1_table table;
  table = spring_rig_v2()->base;
  table.version = TONUS_DRIVER_VERSION;
  table.size = sizeof(table);
  return &table;
}
