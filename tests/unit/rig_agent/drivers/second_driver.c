/* The example driver as a library of version 2 that was built before there were auxiliary channels. */
#undef tonus_driver_v2
#define tonus_driver_v2 spring_rig_v2
#include "examples/driver/spring_rig.c"
#undef tonus_driver_v2

const tonus_driver_v2_table* tonus_driver_v2(void) {
  static tonus_driver_v2_table table;
  const tonus_driver_v2_table* whole = spring_rig_v2();
  memset(&table, 0xff, sizeof table); /* behind its end stands something else */
  memcpy(&table, whole, offsetof(tonus_driver_v2_table, count_auxiliary));
  table.base.size = offsetof(tonus_driver_v2_table, count_auxiliary);
  return &table;
}
