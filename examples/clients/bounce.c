/*
 * A plain C program: a ball bounces on a plate, its contact a table (contact-patch curve ball.json --format c --name ball -o ball_spring.h).
 * Fourth-order Runge & Kutta steps; no damping, so that the ball has to come back as fast as it came. Exit 0: it does.
 */
#include <math.h>
#include <stdio.h>
#include <time.h>

#include "ball_spring.h"

#define STEPS 4000

/* Ball of steel, 10 mm in radius; effective modulus of the scene. */
static const double mass = 0.0327, radius = 0.01, modulus = 1.1538461538461539e11;

int main(void) {
    const double v0 = 0.5;
    /* Hertz: (8/15) E* sqrt(R) d^(5/2) = m v^2/2; the contact lasts 2.943 d/v. */
    const double deepest = pow(15.0 / 16.0 * mass * v0 * v0 / (modulus * sqrt(radius)), 0.4);
    const double duration = 2.9432750580 * deepest / v0, h = duration / STEPS;
    double d = 0.0, v = v0, largest = 0.0, drift = 0.0, sum = 0.0, seconds, restitution;
    long k, steps = 0;
    clock_t start;
    while (!(d < 0.0 && v < 0.0) && steps < 2 * STEPS) {
        double a1 = -ball_force(d) / mass, v2 = v + 0.5 * h * a1;
        double a2 = -ball_force(d + 0.5 * h * v) / mass, v3 = v + 0.5 * h * a2;
        double a3 = -ball_force(d + 0.5 * h * v2) / mass, v4 = v + h * a3;
        double a4 = -ball_force(d + h * v3) / mass, hertz, energy;
        d += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        largest = d > largest ? d : largest;
        hertz = d > 0.0 ? 8.0 / 15.0 * modulus * sqrt(radius) * pow(d, 2.5) : 0.0;
        energy = 0.5 * mass * v * v + hertz;
        drift = fmax(drift, fabs(energy / (0.5 * mass * v0 * v0) - 1.0));
        steps++;
    }
    restitution = -v / v0;
    start = clock();
    for (k = 0; k < 20000000; k++) {
        sum += ball_force(deepest * 5e-8 * (double)k);
    }
    seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    printf("restitution - 1            %.1e\n", restitution - 1.0);
    printf("energy drift against Hertz %.1e\n", drift);
    printf("largest depth over Hertz   %.1e\n", largest / deepest - 1.0);
    printf("duration over Hertz        %.1e\n", ((double)steps * h - d / v) / duration - 1.0);
    printf("ns per evaluation          %.1f\n", 1e9 * seconds / 2e7);
    return sum > 0.0 && fabs(restitution - 1.0) < 1e-6 && drift < 3e-6 && fabs(largest / deepest - 1.0) < 1e-6 ? 0 : 1;
}
