#include "services/explain/reason_texts.hpp"

namespace tonus::explain {
namespace {

constexpr Explanation kVerdictReasons[] = {
    {"not completed",
     "The rig did not run the trial to its end, or there is no rest before its onset to measure from. "
     "Nothing else "
     "was judged.",
     "A safety limit stopped the trial; the operator aborted it; the hand did not come to rest on the target "
     "in "
     "time; the rig agent ended in the middle.",
     "Read the trial's end and detail (tonus show): they name the limit or the request. The trial is queued "
     "again "
     "by itself."},
    {"off target",
     "Before the onset the hand was outside the target circle, so that the trial does not belong to its "
     "posture.",
     "The subject does not look at the target; the seat or the arm rest has moved; the posture is "
     "uncomfortable; "
     "the encoders' zero is wrong.",
     "Show the target to the subject again and let him rest. If it happens at one posture only, check the "
     "seat and "
     "the shoulder's place; if at all, run tonus-rig-agent calibrate zero."},
    {"bias not reached",
     "The force on the hand never came within the threshold of the bias force during the hold.",
     "The subject gives way or pushes along; the force sensor's offset has drifted; ramp_s is too short for "
     "the "
     "subject.",
     "Explain the task again: hold the hand where it is. Tare the sensor (tonus-rig-agent calibrate tare); "
     "allow a "
     "longer bias.ramp_s."},
    {"bias not held", "The bias force was reached and left its threshold again before the onset.",
     "The subject changes his force while he waits, or reacts before the perturbation; the threshold is "
     "tighter "
     "than a person can hold.",
     "Practise the hold without perturbations. If most trials fail, widen bias.threshold_N or shorten "
     "bias.hold_s."},
    {"early reaction",
     "The hand moved or pushed before the onset: the arm was not at rest, and what follows is not its "
     "passive "
     "resistance.",
     "The subject foresees the perturbation and braces himself; he is not relaxed; tremor or breathing moves "
     "the "
     "hand; something touches the handle.",
     "Ask the subject to relax and not to guess. Widen perturbation.wait_s, so that the onset cannot be "
     "foreseen. "
     "In instructed conditions, allow for a steadier posture."},
    {"saturated",
     "The force sensor was at its end stop in the rest or the perturbation: the true force is larger than "
     "what was "
     "read.",
     "The subject pushed hard; the perturbation is too strong or too fast for the sensor; the sensor is "
     "overloaded by its cable or its mounting.",
     "Reduce amplitude_m or lengthen rise_time_s; check the sensor at rest, where it should read less than a "
     "tenth "
     "of its range."},
    {"gap",
     "Samples of the trial are missing for good: the archive asked the rig for them and the rig does not "
     "have them "
     "any more. What is missing could say anything, so nothing further is judged.",
     "The rig's disk was full or was exchanged; the rig agent was started on another data folder; a dataset "
     "that "
     "was imported has lines without data.",
     "Look at the spool's size (tonus status) and at free space on the rig's disk. The trial is queued again "
     "by "
     "itself."},
    {"excursion",
     "After the onset the hand moved further than allowed: the arm's impedance is defined for small "
     "displacements "
     "only.",
     "The subject gave way, let go or moved on purpose; the amplitude is close to the limit; an encoder "
     "jumped.",
     "Explain the instruction again (\"do not intervene\"). If it happens without the subject's doing, "
     "reduce "
     "perturbation.amplitude_m."},
    {"not at rest",
     "At the end of the perturbation the hand still moved, so that the displacement that is held is not "
     "known.",
     "The subject acts against the perturbation; the arm rings because hold_s is short; the rig's control is "
     "badly "
     "damped.",
     "Lengthen perturbation.hold_s or end_rest_s; explain the instruction again; check the rig with "
     "tonus-rig-agent calibrate spring."},
    {"unknown rig",
     "There is no description of the rig, so that counts and volts cannot be converted to metres and "
     "newtons.",
     "The rig agent's description has not reached identification; the archive was filled without its rig; "
     "versions "
     "differ.",
     "See tonus status for the rig and its version; restart the rig agent. Trials can be judged again later "
     "from "
     "the archive."},
    {"let go", "The handle was moved and nothing resisted it: no hand was on the handle.",
     "The subject let go or opened his hand when it was moved; the handle is loose on its axle; a force "
     "channel is "
     "not connected.",
     "Ask the subject to keep hold. If he did, tare and test the force sensor by hand (tonus-rig-agent "
     "calibrate "
     "force)."},
    {"muscles active", "The muscles were more active before the onset than the protocol allows.",
     "The subject braces himself or is uncomfortable; the rest before the onset is too short to relax in; an "
     "electrode has come loose and picks up the mains.",
     "Ask the subject to relax and support the arm. Look at the trace: a steady hum of the mains is an "
     "electrode's, not a "
     "muscle's. If the subject cannot relax further, raise limits.muscle_activity."},
    {"rejected by hand", "An operator rejected the trial after its verdict and said why.",
     "What the operator saw: a cough, a slip, a wrong posture.",
     "Nothing: the trial is left out of every estimate and queued again. The review holds the reason and the "
     "name."},
};

}  // namespace

std::span<const Explanation> verdict_reasons() { return kVerdictReasons; }

}  // namespace tonus::explain
