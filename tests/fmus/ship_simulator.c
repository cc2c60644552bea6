/* A ship simulator as an FMU (FMI 2.0, co-simulation) that knows nothing of TruthPlant but the names of its
   inputs: Nomoto's steering in a 10/10 zigzag manoeuvre, heel in turns, pitch and heave in waves, over the
   ellipsoid. It integrates by Runge-Kutta in steps of 5 ms, and stamps its state with the end of its step. */

#include <math.h>
#include <stdlib.h>

#include "fmi2Functions.h"

enum { TIME, POSITION, VELOCITY = 4, ATTITUDE = 7, ACCELERATION = 10, BODY_RATE = 13, COUNT = 16 };
enum { LATITUDE, LONGITUDE, HEADING, YAW_RATE, ROLL, ROLL_RATE, RUDDER, STATES };

static const double kStep = 0.005;                                /* s */
static const double kSpeed = 8.0;                                 /* m/s */
static const double kGain = 0.12, kLag = 12.0;                    /* of Nomoto [1/s], [s] */
static const double kZigzag = 0.17453292519943295;                /* rad, of rudder and heading */
static const double kHeave = 0.4, kWave = 0.8;                    /* m, rad/s */
static const double kPitch = 0.05, kPitching = 0.9;               /* rad, rad/s */
static const double kRolling = 0.7, kDamping = 0.1, kHeel = 0.05; /* rad/s, 1, s/m */

typedef struct {
    double time, state[STATES], rudder;
} Ship;

static void derivative(const Ship* ship, double time, const double* x, double* dx) {
    const double e2 = 0.00669437999014, w2 = 1.0 - e2 * sin(x[LATITUDE]) * sin(x[LATITUDE]);
    const double normal = 6378137.0 / sqrt(w2), meridian = normal * (1.0 - e2) / w2;
    const double height = kHeave * sin(kWave * time);
    dx[LATITUDE] = kSpeed * cos(x[HEADING]) / (meridian + height);
    dx[LONGITUDE] = kSpeed * sin(x[HEADING]) / ((normal + height) * cos(x[LATITUDE]));
    dx[HEADING] = x[YAW_RATE];
    dx[YAW_RATE] = (kGain * x[RUDDER] - x[YAW_RATE]) / kLag;
    dx[ROLL] = x[ROLL_RATE];
    dx[ROLL_RATE] = kRolling * kRolling * (-kHeel * kSpeed * x[YAW_RATE] - x[ROLL]) -
                    2.0 * kDamping * kRolling * x[ROLL_RATE] + 0.02 * sin(0.6 * time);
    dx[RUDDER] = (ship->rudder - x[RUDDER]) / 1.5;
}

static void go(Ship* ship) {
    static const double part[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    double slope[STATES] = {0}, sum[STATES] = {0}, at[STATES];
    for (int stage = 0; stage < 4; ++stage) {
        for (int i = 0; i < STATES; ++i) {
            at[i] = ship->state[i] + part[stage] * kStep * slope[i];
        }
        derivative(ship, ship->time + part[stage] * kStep, at, slope);
        for (int i = 0; i < STATES; ++i) {
            sum[i] += weight[stage] * slope[i];
        }
    }
    for (int i = 0; i < STATES; ++i) {
        ship->state[i] += kStep * sum[i];
    }
    if (ship->rudder * ship->state[HEADING] > kZigzag * kZigzag) {
        ship->rudder = -ship->rudder;
    }
}

static void reset(Ship* ship) {
    *ship = (Ship){.state = {[LATITUDE] = 0.9, [LONGITUDE] = -0.3}, .rudder = kZigzag};
}

static void put_out(const Ship* ship, double* out) {
    const double* x = ship->state;
    const double t = ship->time, yaw = -x[YAW_RATE];
    const double pitch = kPitch * sin(kPitching * t), pitch_rate = kPitch * kPitching * cos(kPitching * t);
    const double cosine = cos(x[HEADING]), sine = sin(x[HEADING]);
    const double values[COUNT] = {
        t,
        x[LATITUDE],
        x[LONGITUDE],
        kHeave * sin(kWave * t),
        kSpeed * sine,
        kSpeed * cosine,
        kHeave * kWave * cos(kWave * t),
        x[ROLL],
        pitch,
        x[HEADING],
        kSpeed * cosine * x[YAW_RATE],
        -kSpeed * sine * x[YAW_RATE],
        -kHeave * kWave * kWave * sin(kWave * t),
        cos(x[ROLL]) * pitch_rate - sin(x[ROLL]) * cos(pitch) * yaw,
        x[ROLL_RATE] + sin(pitch) * yaw,
        sin(x[ROLL]) * pitch_rate + cos(x[ROLL]) * cos(pitch) * yaw,
    };
    for (int i = 0; i < COUNT; ++i) {
        out[i] = values[i];
    }
}

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions* functions, fmi2Boolean visible, fmi2Boolean log) {
    (void)name, (void)guid, (void)resources, (void)functions, (void)visible, (void)log;
    Ship* ship = type == fmi2CoSimulation ? malloc(sizeof *ship) : NULL;
    if (ship != NULL) {
        reset(ship);
    }
    return ship;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean with_tolerance, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean with_stop, fmi2Real stop) {
    (void)with_tolerance, (void)tolerance, (void)with_stop, (void)stop;
    ((Ship*)c)->time = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c == NULL ? fmi2Error : fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return c == NULL ? fmi2Error : fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return c == NULL ? fmi2Error : fmi2OK; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count,
                       fmi2Real values[]) {
    double all[COUNT];
    put_out(c, all);
    for (size_t i = 0; i < count; ++i) {
        if (references[i] >= COUNT) {
            return fmi2Error;
        }
        values[i] = all[references[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean final) {
    (void) final;
    Ship* ship = c;
    const long parts = lround(step / kStep);
    for (long i = 0; i < parts; ++i) {
        ship->time = time + (double)i * kStep;
        go(ship);
    }
    ship->time = time + step;
    return fmi2OK;
}
