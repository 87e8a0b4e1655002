#include "services/explain/reason_texts.hpp"

namespace tonus::explain {
namespace {

constexpr Explanation kEstimateReasons[] = {
    {"too_few_trials",
     "Undetermined: fewer than two valid trials (or blocks of a record), so that no interval can be stated. "
     "No "
     "numbers are given.",
     "The condition has only begun; nearly all of its trials were rejected.",
     "Wait for more trials, or read the verdicts of the rejected ones (tonus show)."},
    {"single_direction",
     "Undetermined: all perturbations act along one line, so that the other column of each matrix is not "
     "excited.",
     "The protocol has one direction (or one and its opposite); all others were rejected so far; a two-axis "
     "record "
     "is driven along one axis only.",
     "Use three directions or more (perturbation.directions); identify a one-axis experiment as a one-axis "
     "rig."},
    {"rank_deficient",
     "Undetermined: the regressors (acceleration, velocity, displacement) are not independent with the "
     "margin that is "
     "asked for; mass, damping and stiffness cannot be told apart.",
     "The motion is too slow to show mass and damping; the window ends before the hand has come to rest; two "
     "channels carry one signal.",
     "Shorten perturbation.rise_time_s, use the whole window, check the channels. The condition number says "
     "how "
     "close it was."},
    {"negative_stiffness",
     "Suspect: the symmetric part of K has an eigenvalue of zero or less. No arm that holds a posture has "
     "that.",
     "The subject moved with the perturbation; force and motion are shifted in time; the force's sign or "
     "axes are "
     "wrong; the posture drifted.",
     "Check force_sign, axes and lag first; then the subject's instruction. Do not use the numbers."},
    {"negative_mass", "Suspect: the symmetric part of M has an eigenvalue of zero or less.",
     "The force lags or leads the motion; the force is filtered and the motion is not; the motion is too "
     "slow to "
     "show mass.",
     "Look at the lag; use method state_variable, which filters both alike; shorten rise_time_s."},
    {"negative_damping",
     "Suspect: the symmetric part of B has an eigenvalue of zero or less: the arm would feed energy into the "
     "motion.",
     "A lag of the force by a few milliseconds; a reflex; slow voluntary drift together with too few trials.",
     "Look at the lag and at the residual's halves; measure more trials; for continuous records use model "
     "reflex."},
    {"collinear_force",
     "Suspect: the two force channels carry one signal, so that only one component of the force was "
     "measured.",
     "One cable feeds both channels; the calibration matrix is singular; a channel is dead and picks up the "
     "other.",
     "Press the handle along each axis by hand and watch both channels; repeat calibrate force."},
    {"force_shifted",
     "Suspect: a force channel leads or lags the displacement by more than is tolerated. Mass and damping "
     "are wrong "
     "by about the lag times damping and stiffness.",
     "The sensor's amplifier filters; force and encoders are sampled by different devices; a recording was "
     "joined "
     "from two files.",
     "Reduce the amplifier's filter, sample both with one device, or correct the recording by the lag that "
     "the "
     "estimate states."},
    {"clipped_force", "Suspect: a force channel stands still at its extreme.",
     "The sensor or its amplifier is overloaded; the input's range is too small.",
     "Use a larger range (range of the card) or a gentler perturbation, and measure again."},
    {"short_trial", "The trial was left out of the fit: it ends before the window does.",
     "hold_s is shorter than the window; the trial was cut by its dataset.",
     "Use a shorter --window, or a longer perturbation.hold_s."},
    {"force_sign",
     "Suspect: M, B and K are all negative. The force has the opposite sign: it is that of the arm on the "
     "handle.",
     "The dataset's convention differs; a channel was connected the wrong way round.",
     "State --force-sign -1 for the dataset, or correct the rig's calibration. Do not turn the results by "
     "hand: "
     "spring centre and bias turn, too."},
    {"too_few_samples", "Undetermined: the records have too few usable rows.",
     "The record is short, or most of its rows are marked as missing.",
     "Record longer; check what is marked as missing."},
    {"no_motion", "Undetermined: displacement or force of an axis does not move.",
     "The motors were off; a channel is not connected; the wrong column was taken for a channel.",
     "Look at the traces; check the dataset's channels table."},
    {"too_few_segments", "Undetermined: between the gaps there are too few segments while the input is on.",
     "The record has many gaps, or the perturbation ran only for a small part of it.",
     "Record longer without gaps; cut the record to the part with perturbation."},
    {"not_coherent",
     "Undetermined: there is no band in which force and motion belong together on every axis.",
     "The perturbation is weaker than noise or than voluntary motion; the channels are not of the same time.",
     "Perturb more strongly; check that both channels share one clock."},
    {"wide_interval",
     "Undetermined: the 95 % interval of a matrix is wider than half of its largest element; the number says "
     "nothing.",
     "Too little data, too much voluntary force, a band that does not reach the resonance.",
     "Measure longer, or more trials; perturb faster for mass, longer for stiffness."},
    {"unexplained_force", "Suspect: the model explains too little of the force's variation.",
     "Voluntary force or tremor; an arm that is not linear for this amplitude; wrong axes or a wrong "
     "shoulder "
     "frame.",
     "Look at the residual over time and position. Reduce the amplitude; ask the subject to relax; compare "
     "the other "
     "models (--model)."},
    {"incoherent", "Suspect: force and motion hardly belong together in the band that was used.",
     "Noise, voluntary force, or an arm that changes during the record.",
     "Perturb more strongly; cut the record into steady parts."},
    {"halves_differ",
     "Suspect: two halves of the data, fitted apart, give matrices that differ by more than their intervals.",
     "The subject changed posture, grip or effort between them; fatigue; a sensor drifted.",
     "Compare the halves' trials; repeat the condition with a rest. Do not average over a change."},
    {"unsteady", "Suspect: parts of a record scatter more than its noise explains.",
     "The subject changed his effort; the record mixes conditions.",
     "Cut the record into steady parts and identify each."},
    {"misfit",
     "Suspect: in a band the response departs from mass, damping and stiffness by more than its uncertainty.",
     "A stretch reflex (3 to 12 Hz); a second mass, as a loose handle or soft tissue; friction of the rig.",
     "The check says in which band. Fix the handle; restrict the band; for a reflex try model reflex."},
    {"lag",
     "Suspect: the lag of the force after the motion is at the end of what is searched, or beyond what is "
     "allowed.",
     "Different devices or filters for force and motion; recordings joined with an offset.",
     "Sample both with one device, or shift the channel and import again."},
    {"few_units", "Suspect: too few independent trials or segments; the interval rests on too little.",
     "A condition with few trials so far; a short record.",
     "Measure more trials of this condition; record longer."},
    {"friction", "Suspect: a part of the force follows the sign of the velocity.",
     "Dry friction in the rig, its bearings or its cables; a handle that rubs.",
     "Reduce or compensate the friction (control.friction_compensation); for records use model friction."},
    {"hardening",
     "Suspect: a part of the force follows the cube of the displacement: the stiffness grows with the "
     "amplitude.",
     "The amplitude is too large for a linear model; a soft stop is reached.",
     "Reduce the amplitude; for records use model cubic."},
    {"position_dependent",
     "Suspect: the stiffness changes with the position within the record; one matrix cannot describe it.",
     "The hand wanders through the workspace; the amplitude is large.",
     "Hold the hand in one place; reduce the amplitude; identify by posture."},
    {"reflex",
     "Suspect: a part of the force follows the displacement 30 to 60 ms late, as a stretch reflex does. One "
     "mass, damping "
     "and stiffness cannot describe it.",
     "The subject's stretch reflex, stronger with fast perturbations and tense muscles; a delayed channel.",
     "Ask the subject to relax, perturb more slowly; for records use model reflex, which has it as "
     "parameters."},
    {"unsettled_model",
     "Undetermined: the coefficients of a model beyond mass, damping and stiffness (friction, cubic, reflex) "
     "do not "
     "settle.",
     "The data hardly show the effect; the record is short or its amplitude small.",
     "Use model linear or auto; measure longer or with another amplitude."},
    {"asymmetric_mass",
     "Suspect: the mass matrix is not symmetric. Kinetic energy is a square, so that every arm's mass is; "
     "the "
     "force is not that of these axes.",
     "Force channels that are swapped, turned against the axes of motion, coupled to each other or of "
     "different "
     "gain; a calibration of another sensor.",
     "Check which channel is which axis, the sensor's angle and its calibration matrix: push along one "
     "axis."},
    {"at_bound",
     "Suspect: a parameter of the model stands at the end of what is searched (a reflex's delay: 20 to 80 "
     "ms), "
     "so that its true value may lie beyond.",
     "The model is not the arm's: something else than a reflex makes the response depart from mass, damping "
     "and "
     "stiffness.",
     "Use another model, or a band in which model linear passes; look at the reasons of --model auto."},
    {"slack",
     "Suspect: a part of the force follows the direction of the displacement, whatever its size, as behind a "
     "slack "
     "or a preload: the stiffness is that of neither a small motion nor a large one.",
     "The hand is loose in the handle, or the handle on the rig; a spring that is preloaded; a sensor with a "
     "dead band.",
     "Strap the hand to the handle and tighten the handle; measure with two amplitudes and compare K."},
    {"methods_differ",
     "Suspect: methods refined and state_variable, the latter as given or less its known bias, differ in an "
     "element by more than their joint 95 % intervals. They see the same noise and make different use of the "
     "motion: on "
     "an arm that M, B, K describe they agree.",
     "The arm or its grip is not what the model says (slack, hardening, a reflex); the command is not what "
     "moved the hand; single trials are far from the others.",
     "Read the other reasons and the verdicts of the last trials; tighten the grip; look at a trial's "
     "traces. "
     "If only this reason stands, measure more trials."},
    {"no_command",
     "Undetermined: method refined needs the commanded displacement, and the trials do not have it.",
     "A dataset without the channels xc and yc; a driver that does not report its command.",
     "Use method state_variable; export or record the commanded displacement."},
    {"held_samples", "Suspect: a channel repeats its samples, or joins those of a slower rate.",
     "The channel was recorded slower than the others and filled up; a driver that returns its last value.",
     "Record every channel at the rate that is stated, or state its own; check the driver."},
};

}  // namespace

std::span<const Explanation> estimate_reasons() { return kEstimateReasons; }

}  // namespace tonus::explain
