#pragma once

/// What the sanitizers find in the vendors' own libraries, as Debian 12 ships them; read by the sanitizers'
/// run-time in every program that links the bus. Included by one source file.

#ifdef __SANITIZE_ADDRESS__
/// Fast DDS deletes a derived statistics listener by its base, which has no virtual destructor.
extern "C" const char* __asan_default_options() { return "new_delete_type_mismatch=0"; }
#endif

#ifdef __SANITIZE_THREAD__
/// Fast DDS takes its timed mutexes by a call that the sanitizer does not know, and only their release is
/// seen. Cyclone DDS counts references with atomics that are invisible to it, so the last holder's release
/// seems to race.
extern "C" const char* __tsan_default_suppressions() {
  return "mutex:libfastrtps\ndeadlock:libfastrtps\nrace:libddsc\nrace:free_serdata\n";
}
#endif
