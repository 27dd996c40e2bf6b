/* The C interface from C: values against Hertz, every error a code with a text, two threads at once. Exit 0: all holds. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <contact_patch.h>

static const char ball[] =
    "{\"name\": \"ball\", \"effective_modulus\": 2.0, \"gap\": {\"kind\": \"paraboloid\", \"radii\": [1.0, 1.0]},"
    " \"loading\": {\"depths\": [0.01, 0.04]}, \"solve\": {\"tolerance\": 1e-3}}";
static const char oval[] =
    "{\"effective_modulus\": 2.0, \"gap\": {\"kind\": \"paraboloid\", \"radii\": [1.0, 3.0]}, \"loading\": {\"depth\": 0.01},"
    " \"solve\": {\"tolerance\": 2e-3}}";

#define CHECK(holds)                                                             \
    do {                                                                         \
        if (!(holds)) {                                                          \
            fprintf(stderr, "%s:%d: %s; message: %s\n", __FILE__, __LINE__, #holds, cp_message()); \
            exit(1);                                                             \
        }                                                                        \
    } while (0)

/* 4/3 E* sqrt(R) d^(3/2). */
static double hertz(double depth) {
    return 4.0 / 3.0 * 2.0 * depth * sqrt(depth);
}

static int near(double value, double truth, double share) {
    return fabs(value - truth) <= share * fabs(truth);
}

static void texts(void) {
    char *result = NULL;
    CHECK(cp_solve(ball, NULL, &result) == CP_SOLVED);
    CHECK(strstr(result, "\"force\"") && strstr(result, "\"ball\""));
    cp_text_free(result);
    result = NULL;
    CHECK(cp_solve("{\"effective_modulus\": 2.0, \"gap\": {\"kind\": \"ball\"}, \"loading\": {\"depth\": 1}}", NULL, &result) == CP_WRONG);
    CHECK(result == NULL && strstr(cp_message(), "gap.kind"));
    CHECK(cp_solve("no scene", NULL, &result) == CP_WRONG);
    CHECK(cp_solve("\xff\xfe", NULL, &result) == CP_WRONG && strstr(cp_message(), "UTF-8"));
    CHECK(cp_solve(NULL, NULL, &result) == CP_WRONG && strstr(cp_message(), "null"));
    CHECK(cp_solve(ball, NULL, NULL) == CP_WRONG);
    /* A line contact has no end, and so no answer; the result says so. */
    CHECK(cp_solve("{\"effective_modulus\": 2.0, \"gap\": {\"kind\": \"paraboloid\", \"radii\": [1.0, \"flat\"]}, \"loading\": {\"depth\": 1}}",
                   NULL, &result) == CP_NOT_SOLVED);
    CHECK(strstr(result, "unbounded") && strstr(cp_message(), "unbounded"));
    cp_text_free(result);
    cp_text_free(NULL);
}

static void curves(void) {
    cp_curve *curve = NULL;
    cp_curve_facts facts;
    double force, stiffness, area, centre[2], depth, d;
    char *text = NULL;
    CHECK(cp_curve_new(ball, NULL, 1e-4, NAN, CP_BEYOND_POWER, 1, &curve) == CP_SOLVED);
    for (d = -0.01; d < 0.06; d += 0.0007) {
        CHECK(cp_curve_evaluate(curve, d, &force, &stiffness) == CP_SOLVED);
        CHECK(d <= 0.0 ? force == 0.0 : near(force, hertz(d), 1e-4));
        CHECK(d <= 0.0 ? stiffness == 0.0 : near(stiffness, 1.5 * hertz(d) / d, 1e-3));
    }
    CHECK(cp_curve_patch(curve, 0.02, &area, centre) == CP_SOLVED);
    CHECK(near(area, 3.14159265358979 * 0.02, 1e-6) && fabs(centre[0]) < 1e-12 && fabs(centre[1]) < 1e-12);
    CHECK(cp_curve_depth(curve, hertz(0.03), &depth) == CP_SOLVED && near(depth, 0.03, 1e-4));
    CHECK(cp_curve_depth(curve, -1.0, &depth) == CP_NOT_SOLVED);
    CHECK(cp_curve_about(curve, &facts) == CP_SOLVED);
    CHECK(facts.deepest == 0.04 && facts.force_error <= 1e-4 && near(facts.exponent, 1.5, 1e-5) && facts.solves == 1);
    CHECK(cp_curve_text(curve, CP_FORM_C_HEADER, "ball", &text) == CP_SOLVED && strstr(text, "double ball_force(double depth)"));
    cp_text_free(text);
    CHECK(cp_curve_text(curve, (cp_form)7, "ball", &text) == CP_WRONG);
    CHECK(cp_curve_evaluate(NULL, 0.1, &force, NULL) == CP_WRONG);
    cp_curve_free(curve);
    CHECK(cp_curve_new(ball, NULL, 1e-4, NAN, CP_BEYOND_REFUSE, 0, &curve) == CP_SOLVED);
    CHECK(cp_curve_evaluate(curve, 0.05, &force, &stiffness) == CP_NOT_SOLVED);
    cp_curve_free(curve);
    CHECK(cp_curve_new(ball, NULL, 0.0, NAN, CP_BEYOND_REFUSE, 1, &curve) == CP_WRONG && strstr(cp_message(), "accuracy"));
    CHECK(cp_curve_new(ball, NULL, 1e-3, 1.0, CP_BEYOND_REFUSE, 1, &curve) == CP_WRONG && strstr(cp_message(), "from"));
    CHECK(cp_curve_new(ball, NULL, 1e-3, NAN, (cp_beyond)9, 1, &curve) == CP_WRONG);
    CHECK(cp_curve_new(ball, NULL, 1e-3, NAN, CP_BEYOND_POWER, -1, &curve) == CP_WRONG && strstr(cp_message(), "threads"));
    cp_curve_free(NULL);
}

static void contacts(void) {
    cp_contact *contact = NULL;
    cp_pose pose = {0.01, {0.0, 0.0}, {0.0, 0.0}};
    cp_reaction here, there, tilted;
    double matrix[9];
    int k;
    CHECK(cp_contact_new(oval, NULL, &contact) == CP_SOLVED);
    CHECK(cp_contact_step(contact, &pose, &here, matrix) == CP_SOLVED);
    CHECK(here.laid && here.error <= 2e-3 && here.error > 0.0 && fabs(here.moment[0]) < 1e-6 * here.force);
    for (k = 0; k < 9; k++) {
        CHECK(near(matrix[k], matrix[3 * (k % 3) + k / 3], 1e-12) || fabs(matrix[k]) < 1e-9);
    }
    /* P ~ d^(3/2). */
    CHECK(near(matrix[0], 1.5 * here.force / 0.01, 0.02));
    /* A body that moves takes its contact along. */
    pose.at[0] = 0.5;
    CHECK(cp_contact_step(contact, &pose, &there, NULL) == CP_SOLVED);
    CHECK(!there.laid && near(there.force, here.force, 1e-5) && near(there.moment[1], -0.5 * here.force, 1e-4));
    /* Small tilts follow the stiffness. */
    pose.at[0] = 0.0;
    pose.tilt[0] = 2e-3;
    CHECK(cp_contact_step(contact, &pose, &tilted, NULL) == CP_SOLVED);
    CHECK(fabs(-tilted.moment[1] - matrix[4] * 2e-3) < 0.05 * matrix[4] * 2e-3);
    pose.depth = -1.0;
    CHECK(cp_contact_step(contact, &pose, &here, matrix) == CP_SOLVED && here.force == 0.0 && matrix[0] == 0.0);
    pose.depth = NAN;
    CHECK(cp_contact_step(contact, &pose, &here, NULL) == CP_NOT_SOLVED && strstr(cp_message(), "depth"));
    CHECK(cp_contact_step(contact, NULL, &here, NULL) == CP_WRONG);
    CHECK(cp_contact_step(NULL, &pose, &here, NULL) == CP_WRONG);
    cp_contact_free(contact);
    cp_contact_free(NULL);
}

/* What two threads share: a curve, and a contact. */
struct shared {
    const cp_curve *curve;
    cp_contact *contact;
    double start;
    double sum;
};

static void *thread(void *given) {
    struct shared *mine = (struct shared *)given;
    int k;
    for (k = 0; k < 40; k++) {
        cp_pose pose = {mine->start + 1e-5 * k, {0.0, 0.0}, {0.0, 0.0}};
        cp_reaction answer;
        double force;
        cp_curve *none = NULL;
        CHECK(cp_curve_evaluate(mine->curve, pose.depth, &force, NULL) == CP_SOLVED && near(force, hertz(pose.depth), 1e-4));
        CHECK(cp_contact_step(mine->contact, &pose, &answer, NULL) == CP_SOLVED && answer.force > 0.0);
        mine->sum += answer.force;
        /* The message is that of this thread. */
        CHECK(cp_curve_new("{}", NULL, mine->start, NAN, CP_BEYOND_POWER, 1, &none) == CP_WRONG && strlen(cp_message()) > 0);
    }
    return NULL;
}

static void threads(void) {
    cp_curve *curve = NULL;
    cp_contact *contact = NULL;
    struct shared given[2];
    pthread_t running[2];
    int k;
    CHECK(cp_curve_new(ball, NULL, 1e-4, NAN, CP_BEYOND_POWER, 2, &curve) == CP_SOLVED);
    CHECK(cp_contact_new(oval, NULL, &contact) == CP_SOLVED);
    for (k = 0; k < 2; k++) {
        given[k].curve = curve;
        given[k].contact = contact;
        given[k].start = 0.01 + 0.001 * k;
        given[k].sum = 0.0;
        CHECK(pthread_create(&running[k], NULL, thread, &given[k]) == 0);
    }
    for (k = 0; k < 2; k++) {
        CHECK(pthread_join(running[k], NULL) == 0);
    }
    CHECK(given[1].sum > given[0].sum);
    cp_contact_free(contact);
    cp_curve_free(curve);
}

int main(void) {
    CHECK(strlen(cp_version()) > 2 && cp_message()[0] == '\0');
    texts();
    curves();
    contacts();
    threads();
    puts("the C interface holds");
    return 0;
}
