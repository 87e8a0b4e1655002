#include "services/explain/reason_texts.hpp"

namespace tonus::explain {
namespace {

constexpr Explanation kFaultReasons[] = {
    {"workspace", "The handle left the allowed circle.",
     "The subject moved; the posture lies near the edge; the encoders' zero is wrong.",
     "Bring the handle back, then tonus clear-fault. Check limits.workspace_centre_m, workspace_radius_m and "
     "the "
     "posture."},
    {"speed", "The handle was faster than allowed.",
     "The subject pulled; the subject let go against a load; an encoder gives bad counts.",
     "When it is safe, tonus clear-fault. If nobody moved, test the encoders before anything else."},
    {"force", "The force at the handle was larger than allowed.",
     "The subject pushed; the sensor's offset drifted; the perturbation is too strong.",
     "Ask the subject to relax, tare the sensor, then tonus clear-fault."},
    {"torque", "The control law asked for more torque than allowed.",
     "The subject held the handle fast; gains are too high; the model of the rig is wrong.",
     "Check [control] and [limits] of the rig's profile against the device, then tonus clear-fault."},
    {"encoder_jump", "A joint moved further in one cycle than it can.",
     "A loose encoder cable, electrical noise, a counter that was reset.",
     "Check cables and grounding; run tonus-rig-agent calibrate zero; then tonus clear-fault."},
    {"sensor_saturated", "A force channel is at its end stop.",
     "The handle is loaded beyond the sensor's range; a broken cable; a wrong input range.",
     "Unload the handle. If the reading stays, exchange the cable or the sensor. Then tonus clear-fault."},
    {"not_finite", "A measured or computed number is not finite.",
     "A driver returns values that are no numbers; a profile with wrong constants.",
     "Run tonus-rig-agent check-driver on the driver; check the profile."},
    {"command_timeout", "Nobody was heard from during a trial: the scheduler is gone or the network is cut.",
     "A host is off or sleeps; a cable is out; the scheduler was killed.",
     "tonus status and tonus doctor say who is missing. When it is back: tonus clear-fault, tonus resume."},
    {"overrun", "The loop missed more periods at once than allowed.",
     "Another program takes the processor; the kernel is not set up for realtime; a driver waits.",
     "tonus doctor lists what is missing for realtime. Then tonus clear-fault."},
    {"emergency_stop",
     "Somebody stopped the rig: on a page, by tonus stop, by a signal, or by the device's button.",
     "An operator or the subject asked for it; the button's line is not connected.",
     "Make sure that everybody is safe. Release the button, then tonus clear-fault."},
    {"driver", "The driver failed, or a sensor is disconnected.",
     "The device is off; a cable is out; another program uses the device.",
     "Read the agent's log for the driver's own words; restore the device; then tonus clear-fault."},
    {"held",
     "The rig is held from outside its loop: after a restart, for a lost partner, or because of another "
     "agent.",
     "See the reason that the hold itself names.", "tonus status names the reason; explain that one."},
    {"watchdog", "The watchdog dropped the torque, or is gone.",
     "The loop stood still for longer than limits.watchdog_s; the watchdog process was ended.",
     "Look for what stopped the loop (tonus doctor, the agent's log). Restart the rig agent, then tonus "
     "clear-fault."},
    {"overrun_rate", "The loop missed a larger share of its periods than allowed.",
     "The machine is too slow or too busy for the rate.",
     "Reduce loop.rate_Hz, move other programs elsewhere, follow tonus doctor."},
    {"encoder_still", "A joint's load changed and its encoder did not move.",
     "The encoder or its coupling is broken; the cable is out; the joint is blocked.",
     "Move the handle by hand and watch the counts; repair; then tonus clear-fault."},
    {"encoder_reversed", "A joint's counts go against what torque and force do to it.",
     "An encoder counts the wrong way; two encoders are exchanged; a motor's polarity is wrong; under a "
     "large load, a motor gives much less torque than it is asked for.",
     "Do not run a trial. Check signs of encoders and motors, and the motors' torque, with the subject "
     "away."},
    {"force_still", "The handle moved and a force channel did not change.",
     "The channel is not connected, or the driver repeats its last value.",
     "Press the handle and watch the channel; repair; then tonus clear-fault."},
    {"force_against_motion", "Force and motion contradict each other, by the torque that was given.",
     "A force channel has the wrong sign or scale; the sensor's angle is wrong; an encoder is wrong; the "
     "rig's "
     "inertia in its file is wrong; the subject pushed along.",
     "Check the sign with a weight (tonus-rig-agent calibrate force) and the counts by hand, with the "
     "subject "
     "away. If the subject pushed, explain the task again."},
    {"energy", "The hand was given more energy in a trial than allowed.",
     "A fast or long perturbation against a stiff arm; a subject who lets himself be carried along.",
     "Reduce amplitude or speed; check limits.trial_energy_J."},
    {"force_jump", "A force channel changed further in one cycle than a force can.",
     "A loose plug; a broken cable; noise of a motor's amplifier in the sensor's cable.",
     "Move the cable and watch the channel; separate it from the motors' cables; then tonus clear-fault."},
};

constexpr Explanation kHoldReasons[] = {
    {"fault", "A safety limit stopped the rig. The line names each one: explain those.",
     "See the faults that are named.", "Remove their cause; then tonus clear-fault, and tonus resume.",
     "fault: "},
    {"loop_stands_still",
     "The loop does not come back from its driver. The torque was dropped by another thread, and by the "
     "watchdog.",
     "A device that hangs; a driver that waits for a reply; a USB bus that was reset.",
     "Switch the device off and on, restart the rig agent; then tonus clear-fault.",
     "the loop stands still: the driver does not return"},
    {"ended_under_power",
     "The last rig agent ended while the rig was under power: what happened to the hand then is not known.",
     "The agent was killed or crashed; the host lost power.",
     "Look at the rig and the subject. When it is safe: tonus clear-fault, tonus resume.",
     "the rig agent ended while the rig was under power"},
    {"latch_unreadable", "The file that says whether the rig was held cannot be read, so the rig is held.",
     "A damaged disk; a file that is no longer the agent's.",
     "Check the disk. Make sure that the rig is safe, then tonus clear-fault writes the file anew.",
     "whether the rig was held is not known"},
    {"watchdog_ended",
     "The watchdog process has ended: nothing would drop the torque if the loop stood still.",
     "Somebody ended it; the host ran out of memory.", "Restart the rig agent; then tonus clear-fault.",
     "the watchdog has ended"},
    {"watchdog_stands_still", "The watchdog process does not look at the loop any more.",
     "The host is overloaded or was suspended.",
     "Relieve the host, restart the rig agent; then tonus clear-fault.", "the watchdog stands still"},
    {"second_agent", "Another agent for the same rig is on the bus.",
     "Two hosts or two units are configured with one rig name; a test was left running.",
     "End one of them, or give it another --rig; then tonus clear-fault.", "a second agent of this rig"},
};

constexpr Explanation kTrialEnds[] = {
    {"completed",
     "The rig ran the trial from its rest to its way back. Whether it counts is the verdict's to say.",
     "This is how a trial should end.", "Nothing."},
    {"aborted", "The trial was ended by request.", "An operator's abort, stop or disarm.",
     "The session asks for it again when it goes on."},
    {"faulted", "A safety limit ended the trial; the detail says which.", "See that fault.",
     "Remove the cause, tonus clear-fault, tonus resume."},
    {"not centred", "The hand did not come to rest on the target in time.",
     "The subject does not follow the handle, or cannot reach the posture.",
     "Let him rest; check the posture and the seat; look at the cue's circle."},
    {"bias not reached", "The bias force did not come within its threshold in time.",
     "The subject gives way; the sensor's offset drifted.", "See the verdict of the same name."},
    {"refused", "The trial was never begun; the detail says why.",
     "The rig is held, not armed, has no room on its disk, or cannot reach the posture.",
     "Do what the detail asks for; tonus status shows the rig."},
    {"broken off", "The agent died in the middle of the trial.",
     "A crash, a kill or a power failure on the rig's host.",
     "Look at the rig, restart the agent, tonus clear-fault, tonus resume."},
};

}  // namespace

std::span<const Explanation> fault_reasons() { return kFaultReasons; }
std::span<const Explanation> hold_reasons() { return kHoldReasons; }
std::span<const Explanation> trial_ends() { return kTrialEnds; }

}  // namespace tonus::explain
