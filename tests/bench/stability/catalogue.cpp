// SPDX-License-Identifier: BSD-3-Clause
// The table of the cases. A bound is what the code promises where it promises something, else the rounding of
// the inputs with room for a factor of ten.
#include <cstdio>
#include <string>

#include "tests/bench/stability/cases.hpp"

namespace sortie::bench {

namespace {

constexpr StabilityCase kCases[] = {
    {"rt", "pitch at +-90 degrees", "the sine of the pitch is flat there: half of its digits say nothing",
     "asin of the sine", "atan2 of sine and cosine", "error, rad", 1e-14, pitch_at_90},
    {"rt", "small rotation from a quaternion", "w is 1 to all digits below 1e-8 rad", "2 acos(w)",
     "atan2 of the vector's length and w, a series near 0", "relative error of the angle", 1e-14,
     small_angle_of_quaternion},
    {"rt", "rotation by zero and by a denormal",
     "the square of the angle underflows, the axis has no direction", "sin(angle / 2) / angle",
     "a series without a division by the angle", "error of the quaternion", 1e-14, zero_rotation_vector},
    {"rt", "matrix of half a turn", "w goes to 0 and the other parts are divided by it",
     "quaternion from the trace", "the largest of the four parts first", "error, rad", 1e-14,
     half_turn_matrix},
    {"rt", "opposite directions", "no shortest rotation between them, the cross product is zero",
     "cross product and acos", "half a turn about an axis square to the first", "miss, relative", 1e-14,
     opposite_directions},
    {"rt", "two signs of a quaternion", "q and -q are the same rotation", "mean of the four parts",
     "slerp on the shorter arc", "error of the middle, rad", 1e-14, two_signs},
    {"rt", "zero quaternion", "it has no direction", "division by its length", "no rotation",
     "change of a vector's length, m", 1e-14, zero_quaternion},
    {"rt", "an angle of 1e8 rad", "16 million turns to take off",
     "one turn after the other is subtracted: rounding each time, and a loop without a bound",
     "one multiple of a turn", "error, rad", 1e-7, many_turns},
    {"rt", "sine of 1e22", "a double's turn is off by 2e-16, times 1e21 turns",
     "remainder by a turn in double", "exact reduction", "error", 2.3e-16, sine_of_large},
    {"rt", "length of a denormal vector", "squares underflow to zero", "sqrt(x^2 + y^2)", "scaled squares",
     "relative error", 1e-14, denormal_length},
    {"rt", "length of a vector beyond 1e240", "squares overflow", "sqrt(x^2 + y^2)", "scaled squares",
     "relative error", 1e-14, long_length},
    {"rt", "ring whose indices wrap", "after 2^32 elements an index starts at 0 again",
     "positions compared as numbers", "differences modulo 2^32", "lost of 20 elements", 0, wrapped_ring},
    {"rt", "one stamp a year ahead", "a filter that believes it waits for a year",
     "what is newer than all before is taken", "a doubted step needs eight samples that agree",
     "good samples refused of 1000", 0, wild_stamp},
    {"rt", "clock set back by an hour", "every stamp is older than the newest",
     "what is newer than all before is taken", "eight samples that agree begin a new time line",
     "good samples refused of 1000", 8, clock_set_back},
    {"rt", "stamps at the ends of 64 bits", "their differences overflow",
     "the difference, as the processor makes it", "what is beyond 146 years is refused before",
     "wild stamps taken of 4", 0, extreme_stamps},
    {"rt", "full counter", "after 4,294,967,295 comes 0", "plain addition", "stays at the top",
     "counts short of the top", 0, full_counter},
    {"rt", "rank of a percentile", "0.07 times 100 is more than 7 in binary", "ceil(share * count)",
     "a hair less before rounding up", "wrong ranks of 100", 0, rank_of_share},

    {"rt", "every wake-up late by 0.3 ms",
     "lateness adds up where the next release is counted from the last wake-up", "next = now + period",
     "release = phase + job x period", "shift after ten minutes, s", 0, late_releases},

    {"estimators", "attitude through the gimbal lock", "yaw turns without a limit where pitch is 90 degrees",
     "yaw, pitch and roll integrated (Runge-Kutta 4)", "quaternion, exponential map",
     "error after 10 s at 1 rad/s, rad", 1e-9, gimbal_lock},
    {"estimators", "each sample twice", "no time passes between the two", "rate times the nominal step",
     "true stamps, a repeated one is refused", "heading error after 5 rad, rad", 1e-9, repeated_samples},
    {"estimators", "zero dt between two poses", "their slope is 0 / 0",
     "interpolation between the newest two", "stamps must rise", "error of the position, m", 1e-12,
     zero_interval},
    {"estimators", "huge dt: one stamp an hour ahead", "a rate held for an hour is 1800 rad",
     "rate times the difference of stamps", "a wide step waits for the next sample",
     "heading error after 5 rad, rad", 1e-9, huge_interval},
    {"estimators", "coning at 10 Hz, 100 samples a second", "turns about changing axes do not add up",
     "each mean rate as a turn of its own", "coning correction from two samples",
     "error after 10 s, rad; the bound is a tenth of the naive method's closed form", 5.07e-3, coning},
    {"estimators", "drift of 24 hours in float",
     "a turn as slow as the earth's: 5.5 million steps of 5e-7, each rounded to 6e-8",
     "product and normalisation in float", "the change is added, its rounding carried along",
     "error after a day, rad; the bound is 0.01 degrees", 1.745e-4, day_in_float, true},
    {"estimators", "ten million increments of 1e-9 to 1", "each is below half a step of a float",
     "+=", "compensated sum", "error of 0.01", 1e-6, tiny_increments},
    {"estimators", "low-pass with steps of 100 time constants",
     "the explicit step multiplies the error by -99", "value += dt / tau (in - value)",
     "trapezoidal rule, stable for any step", "largest distance from the input, which was 1 at first", 1,
     slow_value_wide_steps},
    {"estimators", "turning centre of a balanced load", "the quadratic's first coefficient goes to zero",
     "the textbook's root", "the root's form without a difference", "error, m", 1e-15, balanced_load},

    {"estimators", "5 % of the samples are lost", "their part of the turn is missing",
     "rate times the nominal step", "true stamps", "heading error after 10 rad, rad", 1e-9, lost_samples},
    {"estimators", "one sample is no number", "what it is added to stays no number", "integrated as it comes",
     "refused before the state, its time bridged", "heading error after 5 rad, rad", 1e-9,
     one_without_number},
    {"estimators", "one force of 1e30 m/s^2", "a low-pass forgets it after 70 time constants",
     "a low-pass of 3 s", "a reading beyond the sensor's range is none", "inclination 30 s later, rad", 1e-6,
     one_absurd_force},
    {"estimators", "turning at 100 rad/s, 100 samples a second", "one radian a step is no small turn",
     "q += dt / 2 q w", "exponential map", "error after 10 s, rad", 1e-9, fast_turn},
    {"estimators", "a push of 3 m/s^2 for 10 s", "it looks like a slope of 17 degrees", "a low-pass of 3 s",
     "the tracks' acceleration is taken out", "worst inclination, rad; the bound is 0.1 degrees", 1.745e-3,
     long_push},
    {"estimators", "blows of 160 m/s^2, one sample each second", "their mean is 1.6 m/s^2",
     "a low-pass of 3 s", "a sample counts 15 m/s^2 and twice the mean deviation at most",
     "worst inclination, rad; the bound is that of such samples with a quarter for the low-pass", 0.0195,
     blows},
    {"estimators", "a gyro clipped at 35 rad/s for a second",
     "a turn of 15 rad is missing, and nothing tells of it", "the reading's noise alone is doubted",
     "the deviation of the heading grows to that of any heading",
     "heading error in the deviations that are claimed", 3, clipped_gyro},

    {"mapping", "ten thousand rigid transforms", "rounding of each stays in the map",
     "points moved by each one, in float", "one pose of the whole grid, normalised",
     "a point's distance from its place after a full turn, m", 1e-9, many_transforms},
    {"mapping", "mean of points 10 km from the origin",
     "a float's step is 1 mm there, that of a sum of 500 0.5 m", "sum of world coordinates in float",
     "whole steps within the cell", "error, m; a step is 1.5e-6", 3e-6, far_from_origin},
    {"mapping", "normal 10 km from the origin", "squares are 1e8, the spread is 1e-2",
     "mean of squares less square of the mean, in float", "whole numbers relative to the cell, exact",
     "sine of the error; the bound is 0.4 degrees", 7e-3, far_normals},
    {"mapping", "collinear points", "no plane is better than another", "cross product of two rows",
     "some normal square to the line", "cosine to the line, and length off 1; single precision", 1e-6,
     collinear_points},
    {"mapping", "coplanar points, planes along the axes", "two rows of the matrix may be parallel",
     "cross product of the first two rows", "the longest of the three cross products",
     "sine of the error; single precision", 1e-6, coplanar_points},
    {"mapping", "duplicate points", "no spread at all", "curvature as a share of the spread",
     "no normal is claimed", "claims", 0, duplicate_points},
    {"mapping", "10^9 insertions in one voxel", "counts and sums overflow or no longer grow",
     "sum in float, divided by the count", "the count saturates at 65,535, the mean stays",
     "error of the mean, m; a step is 1.5e-6", 3e-6, billion_insertions},
    {"mapping", "cells about the origin", "-0.5 and 0.5 are both cut to 0", "conversion to int",
     "rounding down", "voxels missing of 8", 0, around_zero},
    {"mapping", "a wall seen 100,000 times is taken away", "its log-odds are 200,000 nats", "sum in double",
     "saturating steps", "misses until it is free", 16, log_odds_recovery},
    {"mapping", "log-odds at the upper end", "127 and 16 are more than a byte holds", "addition of bytes",
     "saturating addition", "probability that the wall is none, at worst", 1e-6, log_odds_wrap},
    {"mapping", "a certain cell", "a probability that was rounded to 1 stays there",
     "Bayes' rule on probabilities", "log-odds with an end", "probability after 100 hits and 100 misses", 0.5,
     certain_cell},
    {"mapping", "the mirror image of a place", "all distances are right, and all heights",
     "distances that agree two by two", "a set has to be laid by one pose", "places of 100 that are taken", 0,
     mirrored_place},
    {"mapping", "two rooms that are alike", "each has all that the local map has",
     "distances that agree two by two", "a second pose with nearly as many segments makes it ambiguous",
     "places of 100 that are taken", 0, rooms_alike},
    {"mapping", "things above each other", "they do not say which way the robot looks",
     "least squares, whatever their spread", "a set in a row is no place",
     "worst error of the heading in 100 places, rad; the bound is 5 degrees", 0.0873, things_in_a_row},
    {"mapping", "places in earth-centred coordinates", "a float's step is 0.5 m there", "distances in float",
     "whole centimetres", "right pairs of 1000 that disagree by more than 20 cm", 0, earth_centred_places},
    {"mapping", "the axis of a corridor 100 m long", "a turn has a lever of 50 m, a move has none",
     "eigenvalues of all six below a thousandth of the largest",
     "moves and turns apart (Schur complement), against the normals' own noise",
     "worst angle between the axis and a direction that is called weak, rad; the bound is 10 degrees", 0.1745,
     corridor_axis},

    {"planner", "a ray through 500 cells that are free to 1e-7", "differences of products that are almost 1",
     "the published difference of products", "summation by parts: nothing is subtracted",
     "relative error of the worth", 1e-12, product_of_probabilities},
    {"planner", "a cell covered by 4000 rays", "what is left is 3e-18", "what was seen, from 0 to 1",
     "what is left, from 1 to 0", "relative error of what is left", 1e-3, thousands_of_rays},
    {"planner", "ties between rays", "a heap's order among equals depends on its history",
     "heap by worth alone", "worth, then number: no two are equal",
     "places of 200 that depend on the order of entry", 0, ties},
    {"planner", "Riccati equation at q/r = 1e18", "a lag of 0.1 ms beside steps of 1 and 50 ms",
     "doubling in double", "twice the precision, refined by Newton's method",
     "residual of the equation, relative", 1e-14, stiff_riccati},
    {"planner", "uncontrollable and unstable", "no gain can hold the system",
     "value iteration: a gain comes out", "refused", "spectral radius of what is handed out, 0 for nothing",
     0.999, unstabilisable},
    {"planner", "uncontrollable but stable", "the reachability matrix is singular", "Ackermann's formula",
     "the Riccati equation needs no reachability", "error of the gain", 1e-12, uncontrollable_but_stable},
    {"planner", "a step of 500 time constants", "terms of 1e215 that cancel", "Taylor's series of e^-500",
     "scaling and squaring", "error", 1e-12, stiff_step},
    {"planner", "exact step of a singular system", "an integrator has no inverse", "A^-1 (e^A - 1) B",
     "the exponential of the augmented matrix", "error of the input's effect", 1e-12, singular_step},
    {"planner", "driving straight on", "the centre of rotation lies at infinity", "a circle about it",
     "speed and turn rate, no radius", "error after 3 cm, m", 1e-9, straight_line},
    {"planner", "landing on a target", "the last step is shorter than all others",
     "full rate toward the target", "the rate that still ends there", "distance after 9 s", 1e-12,
     landing_on_target},
    {"planner", "a turn rate of 5e-324 beside a speed", "ratios of ways and their jerks round to zero",
     "the ramp stretched by the ratio of the ways", "what goes nowhere is not stretched",
     "distance from the wish after 5 s, m/s and rad/s", 1e-12, denormal_wish},

    {"drivers", "device time in 16 bits", "a counter of 100 us starts again every 6.6 s",
     "differences added up", "the long stamp nearest before that of the bus", "error over 20 s, s", 1e-9,
     short_device_time},
    {"drivers", "a fragment whose offset and size wrap", "their sum in 32 bits is small again",
     "offset + size <= size of the message", "fragments are counted, not put together",
     "bytes written beyond the message", 0, wrapping_fragment},

    {"hil", "friction 0 on a slope", "the cone of friction has no width", "side forces as shares of mu",
     "the cone's projection", "error of the speed after 1 s, m/s", 1e-2, no_friction},
    {"hil", "friction 10 on a slope", "friction stops the vehicle in a fraction of a step",
     "friction against the speed, explicit", "friction as a condition on the speed after the step",
     "way while it should stand for 5 s, m", 1e-4, high_friction},
    {"hil", "motor lag of 0.1 ms, steps of 20 ms", "the explicit step multiplies the error by -199",
     "speed += dt / lag (target - speed)", "solved exactly within the step", "error after 0.2 s, m/s", 1e-12,
     fast_motor},
    {"hil", "suspension of 1 kHz, steps of 20 ms", "125 radians of oscillation a step", "explicit Euler",
     "solved exactly within the step", "error after 0.2 s, m", 1e-12, stiff_suspension},
    {"hil", "28 kg on flippers of a gram",
     "each impulse moves the light one 28,000 times as much as the heavy one",
     "ten sequential impulses a step", "Newton's method for joints and contacts together",
     "change of height from 2 s to 5 s, m", 1e-4, heavy_on_light},
    {"hil", "5 cm deep in the ground", "a spring stiff enough for the weight holds 120 J a kilogram there",
     "a spring that carries the weight at 0.1 mm", "positions are corrected, without speed",
     "height reached above the ground, m", 1e-2, deep_penetration},
};

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

std::span<const StabilityCase> stability_cases() { return kCases; }

std::string stability_catalogue() {
  std::string text;
  std::string group;
  for (const StabilityCase& one : kCases) {
    if (group != one.group) {
      group = one.group;
      text +=
          "\n## " + group + "\n\n| case | why it is hard | the naive method | ours | measured | bound |\n";
      text += "|---|---|---|---|---|---:|\n";
    }
    for (const char* cell : {one.name, one.why, one.naive, one.ours, one.measure})
      text += "| " + std::string(cell) + " ";
    text += "| " + number_text(one.bound) + " |\n";
  }
  return text;
}

}  // namespace sortie::bench
