/*
 * contact_patch: elastic contact of two bodies, from C.
 *
 * Every function that can fail returns a cp_status; cp_message() is then a sentence about it, of this thread, until its next call. Nothing
 * of an output is written unless the status says so. No call ends the program: what goes wrong inside comes back as CP_INTERNAL.
 *
 * A cp_curve does not change and may be used by any number of threads at once. Calls on one cp_contact wait for each other.
 * Null is no place for an output: CP_WRONG. Freeing null does nothing.
 */
#ifndef CONTACT_PATCH_H
#define CONTACT_PATCH_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum cp_status {
    CP_SOLVED = 0,     /* as asked for */
    CP_NOT_SOLVED = 1, /* a verdict other than solved; of cp_solve the result is there all the same */
    CP_WRONG = 2,      /* the scene or an argument is wrong: the message names the place, what was given, what is allowed */
    CP_INTERNAL = 3    /* a fault of the library; please report it */
} cp_status;

/* What a curve says beyond its largest depth. */
typedef enum cp_beyond {
    CP_BEYOND_POWER = 0,   /* the power law that continues force and stiffness */
    CP_BEYOND_TANGENT = 1, /* the tangent */
    CP_BEYOND_REFUSE = 2   /* nothing: CP_NOT_SOLVED */
} cp_beyond;

/* Forms of a curve as text. */
typedef enum cp_form {
    CP_FORM_CSV = 0,
    CP_FORM_JSON = 1,
    CP_FORM_C_HEADER = 2
} cp_form;

typedef struct cp_curve cp_curve;
typedef struct cp_contact cp_contact;

/* Where a body is: approach at the origin, tilts in radians (overlap = depth + tilt[0] x + tilt[1] y - gap), and how far it has moved along
   the surface. */
typedef struct cp_pose {
    double depth;
    double tilt[2];
    double at[2];
} cp_pose;

/* What a contact answers: force, moments about the origin (moment[0] = integral of p y, moment[1] = -integral of p x), area of the patch,
   estimate of the relative error of the force, and whether the step had to lay a grid. */
typedef struct cp_reaction {
    double force;
    double moment[2];
    double area;
    double error;
    int laid;
} cp_reaction;

/* A curve as a whole: depths of first touch and of the end, estimates of the largest relative errors of force and stiffness between, the
   power law force = coefficient overlap^exponent, states that were solved. */
typedef struct cp_curve_facts {
    double first_touch;
    double deepest;
    double force_error;
    double stiffness_error;
    double coefficient;
    double exponent;
    size_t solves;
} cp_curve_facts;

/* Version of the library. */
const char *cp_version(void);

/* About the last call of this thread that failed; empty when none did. */
const char *cp_message(void);

/*
 * Solves a scene (JSON, as the program reads it) and writes its result (JSON). Files that the scene names are looked for in `directory`;
 * null: in the current one. With CP_SOLVED and CP_NOT_SOLVED *result is a text to be freed by cp_text_free.
 */
cp_status cp_solve(const char *scene, const char *directory, char **result);
void cp_text_free(char *text);

/*
 * The non-linear spring of a scene up to its largest load: relative error of the force `accuracy` between the states, the first at depth
 * `from` (NaN: chosen), on `threads` threads (0: one a core). *curve is to be freed by cp_curve_free.
 */
cp_status cp_curve_new(const char *scene, const char *directory, double accuracy, double from, cp_beyond beyond, int threads,
                       cp_curve **curve);
/* Force and stiffness at a depth. Either place may be null. */
cp_status cp_curve_evaluate(const cp_curve *curve, double depth, double *force, double *stiffness);
/* Area and centre of pressure at a depth. Either place may be null; CP_NOT_SOLVED where the method gives no centre. */
cp_status cp_curve_patch(const cp_curve *curve, double depth, double *area, double centre[2]);
/* Depth at a force. */
cp_status cp_curve_depth(const cp_curve *curve, double force, double *depth);
cp_status cp_curve_about(const cp_curve *curve, cp_curve_facts *facts);
/* The curve as a text, to be freed by cp_text_free; `name` is that of the functions in a C header, null: "contact". */
cp_status cp_curve_text(const cp_curve *curve, cp_form form, const char *name, char **text);
void cp_curve_free(cp_curve *curve);

/*
 * A contact that is asked step by step, each from what the last one left: bodies, gap, tolerance of the scene; its loading is not used.
 * *contact is to be freed by cp_contact_free.
 */
cp_status cp_contact_new(const char *scene, const char *directory, cp_contact **contact);
/* The reaction in a pose; zero where the bodies are apart. `stiffness`, null or 9 doubles: the symmetric derivative of (force, integral of
   p x, integral of p y) by (depth, tilt[0], tilt[1]). */
cp_status cp_contact_step(cp_contact *contact, const cp_pose *pose, cp_reaction *reaction, double *stiffness);
void cp_contact_free(cp_contact *contact);

#ifdef __cplusplus
}
#endif

#endif
