/*
 * Stands in for the vendor's command layer: the same symbols, structs and return codes. The arm behind it lives in
 * another process (arm.py) and in the memory that both map; its habits are there, only those of the cable are here.
 *
 * Compiled once for each layer and layout: -DACTUATORS=7 or 6, -DETHERNET for the layer with the prefix.
 */
#include "standin.h"

#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#ifdef ETHERNET
#define SYMBOL(name) Ethernet_##name
#else
#define SYMBOL(name) name
#endif

enum {
#define FUNCTION(name) ID_##name,
#include "functions.def"
#undef FUNCTION
};

static Memory *memory;
static int started;

static int start(void) {
    const char *path = getenv("BURNISH_STANDIN");
    if (memory == NULL) {
        struct stat file;
        int descriptor = path ? open(path, O_RDWR) : -1;
        if (descriptor < 0 || fstat(descriptor, &file) || file.st_size < (off_t)sizeof(Memory)) return INIT_FAILED;
        memory = mmap(NULL, sizeof(Memory), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
        close(descriptor);
        if (memory == MAP_FAILED) {
            memory = NULL;
            return INIT_FAILED;
        }
    }
    started = 1;
    return SUCCESS;
}

/* What the cable, or a test, makes of a call before it reaches the arm. */
static int passes(int id) {
    if (memory == NULL) return NOT_STARTED;
    __atomic_add_fetch(&memory->calls[id], 1, __ATOMIC_RELAXED);
    if (memory->times[id]) {
        if (memory->times[id] > 0) memory->times[id]--;
        return memory->code[id];
    }
    if (memory->unplugged) return memory->unplugged;
    return started ? SUCCESS : NOT_STARTED;
}

static int send(int id, const float *values, int count) {
    /* A test may let a call be lost on its way, and return success all the same. */
    int lost = memory && memory->times[id] && memory->code[id] == SUCCESS;
    int code = passes(id);
    if (code != SUCCESS || lost) return code;
    uint32_t head = memory->head;
    if (head - __atomic_load_n(&memory->tail, __ATOMIC_ACQUIRE) >= SLOTS) return COMM_FAILED;
    Entry *entry = &memory->ring[head % SLOTS];
    entry->function = id;
    memset(entry->value, 0, sizeof entry->value);
    if (count) memcpy(entry->value, values, sizeof(float) * (size_t)count);
    __atomic_store_n(&memory->head, head + 1, __ATOMIC_RELEASE);
    return SUCCESS;
}

/* A real arm lives on while this computer is busy; the arm's process here may not get the processor. The reading then
 * comes late, as it would over a real cable to a busy computer, and not with what the arm said long before. */
static void wait_for_the_arm(void) {
    const struct timespec nap = {.tv_nsec = 500000};
    for (int naps = 0; naps < 200; naps++) {
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        double lived = *(volatile double *)&memory->lived;
        if (lived == 0.0 || (double)now.tv_sec + 1e-9 * (double)now.tv_nsec - lived < 0.012) return;
        nanosleep(&nap, NULL);
    }
}

/* Copy six numbers that belong to one tick of the arm. */
static void copy(const float *from, float *to) {
    wait_for_the_arm();
    uint32_t before, after;
    int patience = 100000;
    do {
        before = __atomic_load_n(&memory->state_sequence, __ATOMIC_ACQUIRE);
        memcpy(to, from, sizeof(float) * JOINTS);
        __atomic_thread_fence(__ATOMIC_ACQUIRE);
        after = __atomic_load_n(&memory->state_sequence, __ATOMIC_RELAXED);
    } while ((before != after || before % 2) && --patience);
}

static int angles(int id, size_t field, AngularPosition *answer) {
    int code = passes(id);
    if (code != SUCCESS) return code;
    memset(answer, 0, sizeof *answer);
    copy((const float *)((const char *)memory + field), answer->Actuators.Actuator);
    memcpy(answer->Fingers.Finger, memory->fingers, sizeof memory->fingers);
    if (memory->garbage) {
        if (memory->garbage > 0) memory->garbage--;
        for (int joint = 0; joint < JOINTS; joint++) answer->Actuators.Actuator[joint] = memory->garbage_value;
    }
    return SUCCESS;
}

#define PLAIN(name) \
    int SYMBOL(name)(void) { return send(ID_##name, NULL, 0); }
#define TAKES_INT(name) \
    int SYMBOL(name)(int value) { float number = (float)value; return send(ID_##name, &number, 1); }
#define TAKES_FLOAT(name) \
    int SYMBOL(name)(float value) { return send(ID_##name, &value, 1); }
#define TAKES_BUFFER(name, count) \
    int SYMBOL(name)(float *values) { return send(ID_##name, values, count); }
#define GIVES_ANGLES(name, field) \
    int SYMBOL(name)(AngularPosition *answer) { return angles(ID_##name, offsetof(Memory, field), answer); }

PLAIN(StartControlAPI)
PLAIN(StopControlAPI)
PLAIN(SetAngularControl)
PLAIN(MoveHome)
PLAIN(InitFingers)
PLAIN(EraseAllTrajectories)
TAKES_INT(SwitchTrajectoryTorque)
TAKES_INT(SetTorqueControlType)
TAKES_INT(SetTorqueZero)
TAKES_INT(SetJointZero)
TAKES_INT(SetTorqueInactivityType)
TAKES_INT(SetGravityType)
TAKES_FLOAT(SetTorqueSafetyFactor)
TAKES_FLOAT(SetTorqueVibrationController)
TAKES_BUFFER(SetTorqueActuatorGain, 6)
TAKES_BUFFER(SetTorqueActuatorDamping, 6)
TAKES_BUFFER(SetGravityPayload, 4)
TAKES_BUFFER(SetGravityOptimalZParam, 42)
GIVES_ANGLES(GetAngularPosition, position)
GIVES_ANGLES(GetAngularVelocity, velocity)
GIVES_ANGLES(GetAngularForce, torque)
GIVES_ANGLES(GetAngularCommand, command)

#ifdef ETHERNET
int SYMBOL(InitEthernetAPI)(EthernetCommConfig *configuration) {
    int code = configuration->rxTimeOutInMs && configuration->robotPort ? start() : 2100;
    return code == SUCCESS ? passes(ID_InitEthernetAPI) : code;
}
#else
int SYMBOL(InitAPI)(void) {
    int code = start();
    return code == SUCCESS ? passes(ID_InitAPI) : code;
}
#endif

#if ACTUATORS == 7
int SYMBOL(RunGravityZEstimationSequence7DOF)(int type, float *parameters) { return type || parameters ? 2100 : 2100; }
#endif

int SYMBOL(CloseAPI)(void) {
    int code = passes(ID_CloseAPI);
    if (code == SUCCESS) started = 0;
    return code;
}

int SYMBOL(GetDevices)(KinovaDevice devices[20], int *result) {
    *result = passes(ID_GetDevices);
    if (*result != SUCCESS) return 0;
    for (int i = 0; i < memory->devices; i++) {
        memset(&devices[i], 0, sizeof devices[i]);
        memcpy(devices[i].SerialNumber, memory->serial[i], 20);
        /* Twenty characters, and no zero behind the last of them. */
        memcpy(devices[i].Model, "JACO2 6DOF service  ", 20);
        devices[i].VersionMajor = 6;
        devices[i].VersionMinor = 2;
        devices[i].VersionRelease = 5;
        devices[i].DeviceType = 3;
        devices[i].DeviceID = i;
    }
    return memory->devices;
}

int SYMBOL(SetActiveDevice)(KinovaDevice device) {
    int code = passes(ID_SetActiveDevice);
    if (code == SUCCESS) memcpy(memory->active, device.SerialNumber, 20);
    return code;
}

int SYMBOL(GetAPIVersion)(int answer[3]) {
    answer[0] = 5, answer[1] = 2, answer[2] = 0;
    return passes(ID_GetAPIVersion);
}

int SYMBOL(GetCodeVersion)(int answer[42]) {
    for (int i = 0; i < 42; i++) answer[i] = 0x60205 + i;
    return passes(ID_GetCodeVersion);
}

int SYMBOL(SendBasicTrajectory)(TrajectoryPoint point) {
    float values[VALUES] = {(float)point.Position.Type, (float)point.Position.HandMode};
    memcpy(values + 2, point.Position.Actuators.Actuator, sizeof(float) * JOINTS);
    memcpy(values + 8, point.Position.Fingers.Finger, sizeof(float) * 3);
    return send(ID_SendBasicTrajectory, values, 11);
}

int SYMBOL(GetGlobalTrajectoryInfo)(TrajectoryFIFO *answer) {
    int code = passes(ID_GetGlobalTrajectoryInfo);
    if (code != SUCCESS) return code;
    answer->TrajectoryCount = memory->queued;
    answer->UsedPercentage = (float)memory->queued / 20.0f;
    answer->MaxSize = 2000;
    return SUCCESS;
}

int SYMBOL(GetTrajectoryTorqueMode)(int *answer) {
    int code = passes(ID_GetTrajectoryTorqueMode);
    if (code == SUCCESS) *answer = memory->mode;
    return code;
}

int SYMBOL(GetAngularTorqueGravityEstimation)(float answer[70]) {
    int code = passes(ID_GetAngularTorqueGravityEstimation);
    if (code != SUCCESS) return code;
    /* The vendor writes all 70. */
    memset(answer, 0, sizeof(float) * 70);
    copy(memory->gravity, answer);
    return SUCCESS;
}

int SYMBOL(SendAngularTorqueCommand)(float command[70]) {
    int code = passes(ID_SendAngularTorqueCommand);
    if (code != SUCCESS) return code;
    /* The vendor reads all 70: a shorter buffer shows in a checker of memory. */
    volatile float sum = 0.0f;
    for (int i = 0; i < 70; i++) sum += command[i];
    memcpy(memory->torque_command, command, sizeof(float) * JOINTS);
    __atomic_add_fetch(&memory->torque_sequence, 1, __ATOMIC_RELEASE);
    return SUCCESS;
}

int SYMBOL(SetAngularTorqueMinMax)(AngularInfo least, AngularInfo most) {
    float values[2 * JOINTS];
    memcpy(values, least.Actuator, sizeof(float) * JOINTS);
    memcpy(values + JOINTS, most.Actuator, sizeof(float) * JOINTS);
    return send(ID_SetAngularTorqueMinMax, values, 2 * JOINTS);
}

/* What the compiler made of the structs, for the test that compares. */
#define LAYOUT(what) (int)(what)
int standin_layout(int *answer) {
    int n = 0;
    answer[n++] = LAYOUT(sizeof(AngularInfo));
    answer[n++] = LAYOUT(sizeof(AngularPosition));
    answer[n++] = LAYOUT(sizeof(UserPosition));
    answer[n++] = LAYOUT(sizeof(TrajectoryPoint));
    answer[n++] = LAYOUT(sizeof(KinovaDevice));
    answer[n++] = LAYOUT(sizeof(EthernetCommConfig));
    answer[n++] = LAYOUT(sizeof(TrajectoryFIFO));
    answer[n++] = LAYOUT(sizeof(CartesianInfo));
    answer[n++] = LAYOUT(sizeof(Limitation));
    answer[n++] = LAYOUT(offsetof(AngularPosition, Fingers));
    answer[n++] = LAYOUT(offsetof(UserPosition, CartesianPosition));
    answer[n++] = LAYOUT(offsetof(UserPosition, Actuators));
    answer[n++] = LAYOUT(offsetof(UserPosition, HandMode));
    answer[n++] = LAYOUT(offsetof(UserPosition, Fingers));
    answer[n++] = LAYOUT(offsetof(TrajectoryPoint, LimitationsActive));
    answer[n++] = LAYOUT(offsetof(TrajectoryPoint, SynchroType));
    answer[n++] = LAYOUT(offsetof(TrajectoryPoint, Limitations));
    answer[n++] = LAYOUT(offsetof(KinovaDevice, VersionMajor));
    answer[n++] = LAYOUT(offsetof(KinovaDevice, DeviceID));
    answer[n++] = LAYOUT(offsetof(EthernetCommConfig, localCmdport));
    answer[n++] = LAYOUT(offsetof(EthernetCommConfig, rxTimeOutInMs));
    answer[n++] = LAYOUT(sizeof(Memory));
    return n;
}
