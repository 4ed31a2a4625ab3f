"""The C header's text, as C: ``$name`` and the like are filled in by `compensation.export.export_c`."""

from __future__ import annotations

from string import Template

HEADER = Template("""\
/* Compensator for $target ($unit), written by knitbench $version. Do not edit: export it again.
 *
 *   ${name}_state s;
 *   ${name}_reset(&s);
 *   float p = ${name}_update(&s, conductance_S, dt_s);   // each sample; dt_s: seconds since the last good one
 *   if (s.status != 0u) ...                              // see the flags below
 *
 * A reading that is not finite or not positive, or a bad dt_s, leaves everything as it was and gives the last value
 * again. No heap, no library.
 * Constants $constants_bytes bytes of flash, state $state_bytes bytes of RAM,
 * $scratch_bytes bytes of stack for values, $multiplies multiplications a sample of the nominal step,
 * $multiplies_any_step of any other.
 */
#ifndef ${NAME}_COMPENSATOR_H
#define ${NAME}_COMPENSATOR_H

#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "compile without -ffast-math: faulty readings are recognised by the rules of IEEE 754"
#endif

$flags

#define ${NAME}_FILTERS ${filters}u
#define ${NAME}_INPUTS ${inputs}u
#define ${NAME}_WIDEST ${widest}u
#define ${NAME}_MOTIONS ${motions}u
#define ${NAME}_PLAYS ${plays}u
#define ${NAME}_RATE_HZ $rate
$margins
typedef struct {
    float forced[${NAME}_FILTERS]; /* response from a zero state */
    float lost[${NAME}_FILTERS];   /* what rounding has taken from it so far */
    float fading[${NAME}_FILTERS]; /* what is left of the initial value */
    float start[${NAME}_FILTERS];  /* the initial value: mean of the first samples */
    float elapsed;                /* in steps of 1/rate, until every start is known */
    float value;                  /* the last prediction */
    uint32_t seen;                /* samples so far, as long as a start is not known */
    uint32_t status;              /* flags of the last sample; 0: good */
#if ${NAME}_MOTIONS + ${NAME}_PLAYS > 0
    float settled;                /* the lightly smoothed signal */
    float settled_lost;           /* what rounding has taken from it */
#endif
#if ${NAME}_MOTIONS > 0
    float motion[${NAME}_MOTIONS]; /* its smoothed speeds */
#endif
#if ${NAME}_PLAYS > 0
    float play[${NAME}_PLAYS];     /* its play operators */
#endif
} ${name}_state;

$tables

static inline void ${name}_reset(${name}_state *s) {
    for (uint32_t i = 0u; i < ${NAME}_FILTERS; i++) {
        s->forced[i] = 0.0f;
        s->lost[i] = 0.0f;
        s->fading[i] = 1.0f;
        s->start[i] = 0.0f;
    }
    s->elapsed = 0.0f;
    s->value = $offset;
    s->seen = 0u;
    s->status = ${NAME}_STARTING;
#if ${NAME}_MOTIONS + ${NAME}_PLAYS > 0
    s->settled = 0.0f;
    s->settled_lost = 0.0f;
#endif
#if ${NAME}_MOTIONS > 0
    for (uint32_t i = 0u; i < ${NAME}_MOTIONS; i++) { s->motion[i] = 0.0f; }
#endif
#if ${NAME}_PLAYS > 0
    for (uint32_t i = 0u; i < ${NAME}_PLAYS; i++) { s->play[i] = 0.0f; }
#endif
}

/* 1 - exp(x) for x <= 0, accurate near zero: a series after halving, then squared up again. */
static inline float ${name}_gain(float x) {
    uint32_t halvings = 0u;
    float y = x;
    if (x < -16.0f) {
        y = -1.0f;
    } else {
        while (y < -0.5f) {
            y *= 0.5f;
            halvings++;
        }
        y = y * (1.0f + (y * (0.5f + (y * (1.6666667e-1f + (y * (4.1666667e-2f + (y * (8.3333333e-3f +
            (y * 1.3888889e-3f))))))))));
        for (; halvings > 0u; halvings--) {
            y *= y + 2.0f;
        }
    }
    return -y;
}

static inline void ${name}_layer(const float *in, uint32_t n_in, float *out, uint32_t n_out, const float *w,
                                const float *b, uint32_t relu) {
    for (uint32_t j = 0u; j < n_out; j++) {
        float sum = b[j];
        for (uint32_t i = 0u; i < n_in; i++) {
            sum += w[(j * n_in) + i] * in[i];
        }
        out[j] = ((relu != 0u) && (sum < 0.0f)) ? 0.0f : sum;
    }
}

/* What is wrong with a sample itself; comparisons with a NaN are false. */
static inline uint32_t ${name}_fault(float conductance_S, float dt_s) {
    uint32_t fault = 0u;
    if (!((conductance_S >= $smallest) && (conductance_S <= $largest))) {
        fault |= ${NAME}_BAD_READING;
    }
    if (!((dt_s >= $shortest) && (dt_s <= $longest))) {
        fault |= ${NAME}_BAD_STEP;
    }
    return fault;
}

/* Take one good sample into all memories, in standard deviations; the networks' inputs. */
static inline void ${name}_remember(${name}_state *s, float x, float dt_s, float *features) {
    const uint32_t first = (s->seen == 0u) ? 1u : 0u;
    const float steps = (first != 0u) ? 0.0f : (dt_s * ${NAME}_RATE_HZ);
    const uint32_t nominal = ((steps > 0.999999f) && (steps < 1.000001f)) ? 1u : 0u;
    uint32_t starting = first;
    if (first == 0u) {
        s->elapsed += steps;
    }
    for (uint32_t i = 0u; i < ${NAME}_FILTERS; i++) {
        starting |= (s->elapsed < ${name}_start_steps[i]) ? 1u : 0u;
    }
    if (starting != 0u) {
        s->seen++;
        s->status |= ${NAME}_STARTING;
    } else {
        s->elapsed = ${name}_start_steps[${NAME}_FILTERS - 1u] + 1.0e6f; /* no filter starts any more */
    }
    for (uint32_t i = 0u; i < ${NAME}_FILTERS; i++) {
        const float gain = (nominal != 0u) ? ${name}_alpha[i] : ${name}_gain(${name}_log_keep[i] * steps);
        /* Kahan's sum: a slow filter takes steps that a float would lose. */
        const float step = (gain * (x - s->forced[i])) - s->lost[i];
        const float next = s->forced[i] + step;
        s->lost[i] = (next - s->forced[i]) - step;
        s->forced[i] = next;
        s->fading[i] = (s->fading[i] < 1.0e-12f) ? 0.0f : (s->fading[i] - (gain * s->fading[i]));
        if ((first != 0u) || (s->elapsed < ${name}_start_steps[i])) {
            s->start[i] += (x - s->start[i]) / (float)s->seen;
        }
        const float initial = ${name}_begin_offset[i] + (${name}_begin_gain[i] * s->start[i]);
        features[i] = s->forced[i] + (s->fading[i] * initial);
    }
#if ${NAME}_MOTIONS + ${NAME}_PLAYS > 0
    const float dt = (nominal != 0u) ? (1.0f / ${NAME}_RATE_HZ) : ((first != 0u) ? 0.0f : dt_s);
    const float moved = ((nominal != 0u) ? $settle_gain : ${name}_gain($per_settle * dt)) * (x - s->settled);
    const float step = moved - s->settled_lost;
    const float next = s->settled + step;
    s->settled_lost = (first != 0u) ? 0.0f : ((next - s->settled) - step);
    s->settled = (first != 0u) ? x : next;
#endif
#if ${NAME}_MOTIONS > 0
    const float speed = (dt > 0.0f) ? (((moved < 0.0f) ? -moved : moved) / dt) : 0.0f;
    for (uint32_t i = 0u; i < ${NAME}_MOTIONS; i++) {
        const float slow = (nominal != 0u) ? ${name}_motion_gain[i] : ${name}_gain(${name}_per_s[i] * dt);
        const float begun = ${name}_motion_begin_offset[i] + (${name}_motion_begin_gain[i] * x);
        s->motion[i] = (first != 0u) ? begun : (s->motion[i] + (slow * (speed - s->motion[i])));
        features[${NAME}_FILTERS + i] = s->motion[i];
    }
#endif
#if ${NAME}_PLAYS > 0
    for (uint32_t i = 0u; i < ${NAME}_PLAYS; i++) {
        const float r = ${name}_play_radius[i], low = s->settled - r, high = s->settled + r;
        if (first != 0u) {
            s->play[i] = ${name}_play_begin_offset[i] + (${name}_play_begin_gain[i] * x);
        }
        s->play[i] = (s->play[i] < low) ? low : s->play[i];
        s->play[i] = (s->play[i] > high) ? high : s->play[i];
        features[${NAME}_FILTERS + ${NAME}_MOTIONS + i] = s->play[i];
    }
#endif
}

/* Feed one sample: conductance in S, seconds since the last good one (ignored for the first). Returns $unit. */
static inline float ${name}_update(${name}_state *s, float conductance_S, float dt_s) {
    const float step_s = (s->seen == 0u) ? (1.0f / ${NAME}_RATE_HZ) : dt_s;
    s->status = ${name}_fault(conductance_S, step_s);
    if (s->status == 0u) {
        float features[${NAME}_INPUTS], even[${NAME}_WIDEST], odd[${NAME}_WIDEST], value, result = $offset;
        const float reading = (conductance_S - $mean) * $inverse;
        const float raised = (reading < ${name}_limits[0]) ? ${name}_limits[0] : reading;
        ${name}_remember(s, (raised > ${name}_limits[1]) ? ${name}_limits[1] : raised, dt_s, features);
        if ((reading < ${name}_seen[0]) || (reading > ${name}_seen[1])) {
            s->status |= ${NAME}_UNSEEN_READING;
        }
        for (uint32_t i = 0u; i < ${NAME}_INPUTS; i++) {
            if ((features[i] < ${name}_inputs_low[i]) || (features[i] > ${name}_inputs_high[i])) {
                s->status |= ${NAME}_UNSEEN_HISTORY;
            }
        }
        (void)even;
        (void)odd;
$calls
        s->value = result;
    }
    return s->value;
}

#endif
""")
