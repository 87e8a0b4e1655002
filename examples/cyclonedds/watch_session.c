/* Prints every change of a session's state: Cyclone DDS alone, in C, with the types that idlc makes from
 * idl/session.idl.
 *
 *   tonus-example-cyclonedds [DOMAIN [RIG]]
 */

#include <dds/dds.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

#include "session.h"

static volatile sig_atomic_t is_ended = 0;

static void end(int signal_number) {
  (void)signal_number;
  is_ended = 1;
}

/* Unicast on the loopback only, as the services by default: no packet leaves the machine. */
static const char kConfined[] =
    "<CycloneDDS><Domain Id=\"any\"><General><Interfaces>"
    "<NetworkInterface address=\"127.0.0.1\" multicast=\"false\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>59</"
    "MaxAutoParticipantIndex>"
    "<Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery>"
    "<Internal><GenerateKeyhash>true</GenerateKeyhash></Internal></Domain></CycloneDDS>";

static dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity < 0) {
    fprintf(stderr, "%s: %s\n", what, dds_strretcode(entity));
    exit(1);
  }
  return entity;
}

int main(int argc, char** argv) {
  const dds_domainid_t domain = argc > 1 ? (dds_domainid_t)atoi(argv[1]) : 47;
  signal(SIGINT, end);
  signal(SIGTERM, end);

  checked(dds_create_domain(domain, kConfined), "domain");
  const dds_entity_t participant = checked(dds_create_participant(domain, NULL, NULL), "participant");
  const dds_entity_t topic = checked(
      dds_create_topic(participant, &tonus_v1_SessionState_desc, "session/state", NULL, NULL), "topic");

  /* The reading side of the quality "latest": idl/README.md. */
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  const dds_data_representation_id_t plain_cdr = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos, 1, &plain_cdr);
  const char* rig = argc > 2 ? argv[2] : "rig"; /* "*": every rig of the domain */
  dds_qset_partition(qos, 1, &rig);
  const dds_entity_t reader = checked(dds_create_reader(participant, topic, qos, NULL), "reader");
  dds_delete_qos(qos);

  const dds_entity_t waitset = checked(dds_create_waitset(participant), "waitset");
  const dds_entity_t has_data = checked(dds_create_readcondition(reader, DDS_ANY_STATE), "condition");
  checked(dds_waitset_attach(waitset, has_data, has_data), "waitset");

  while (!is_ended) {
    void* samples[16] = {NULL};
    dds_sample_info_t infos[16];
    dds_waitset_wait(waitset, NULL, 0, DDS_MSECS(200));
    const dds_return_t count = dds_take(reader, samples, infos, 16, 16);
    for (dds_return_t i = 0; i < count; ++i) {
      const tonus_v1_SessionState* state = samples[i];
      if (!infos[i].valid_data) continue;
      printf("phase %d: %u of %u trials counted, %u rejected, posture %s\n", (int)state->phase,
             state->counted, state->planned, state->rejected, state->posture);
      fflush(stdout);
    }
    if (count > 0) dds_return_loan(reader, samples, count);
  }
  dds_delete(participant);
  return 0;
}
