/* A driver of a version that does not exist yet. */
#include "tonus_driver.h"

const tonus_driver_v1_table* tonus_driver_v1(void) {
  static const tonus_driver_v1_table table = {.version = TONUS_DRIVER_VERSION + 1, .size = sizeof(table)};
  return &table;
}
