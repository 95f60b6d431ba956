/* The structs of the command layer, in the layout for ACTUATORS actuators, and the memory shared with the arm. */
#include <stddef.h>
#include <stdint.h>

typedef struct { float Actuator[ACTUATORS]; } AngularInfo;
typedef struct { float X, Y, Z, ThetaX, ThetaY, ThetaZ; } CartesianInfo;
typedef struct { float Finger[3]; } FingersPosition;
typedef struct { AngularInfo Actuators; FingersPosition Fingers; } AngularPosition;
typedef struct { float speed[3], force[3], acceleration[3]; } Limitation;
typedef struct {
    int32_t Type;
    float Delay;
    CartesianInfo CartesianPosition;
    AngularInfo Actuators;
    int32_t HandMode;
    FingersPosition Fingers;
} UserPosition;
typedef struct {
    UserPosition Position;
    int32_t LimitationsActive, SynchroType;
    Limitation Limitations;
} TrajectoryPoint;
typedef struct {
    char SerialNumber[20], Model[20];
    int32_t VersionMajor, VersionMinor, VersionRelease, DeviceType, DeviceID;
} KinovaDevice;
typedef struct { uint32_t TrajectoryCount; float UsedPercentage; uint32_t MaxSize; } TrajectoryFIFO;
typedef struct {
    unsigned long localIpAddress, subnetMask, robotIpAddress;
    unsigned short localCmdport, localBcastPort, robotPort;
    unsigned long rxTimeOutInMs;
} EthernetCommConfig;

enum { SUCCESS = 1, NOT_STARTED = 2101, INIT_FAILED = 2001, NO_DEVICE = 1015, COMM_FAILED = 2004 };
enum { JOINTS = 6, SLOTS = 4096, VALUES = 44, TRACE = 32768, MOST_FUNCTIONS = 64 };

/* One call on its way to the arm: what it was, and up to 44 numbers. */
typedef struct { int32_t function; float value[VALUES]; } Entry;

/* memory.py has the same struct; a test compares the sizes. */
typedef struct {
    /* Written by the arm at each tick of its DSP; odd while it writes. */
    uint32_t state_sequence;
    int32_t mode;
    double time;
    /* Until when an arm on real time has lived, by the machine's monotonic clock [s]; 0: it is not on real time. */
    double lived;
    float position[JOINTS], velocity[JOINTS], torque[JOINTS], gravity[JOINTS], command[JOINTS], fingers[3];
    uint32_t queued;
    /* Written by the library. */
    uint32_t torque_sequence;
    float torque_command[JOINTS];
    uint32_t head, tail;
    uint32_t calls[MOST_FUNCTIONS];
    char active[20];
    /* Switches of the tests, read by the library: what a call returns, how often yet (below 0: always). */
    int32_t code[MOST_FUNCTIONS], times[MOST_FUNCTIONS];
    int32_t unplugged, garbage;
    float garbage_value;
    int32_t devices;
    char serial[2][20];
    /* Switches of the tests, read by the arm. */
    int32_t frozen, refuse_torque_mode, drop_to_position;
    float slowest, fastest, joystick;
    /* The truth, for the tests: t, six joint angles [rad], mode, once in 10 ms. */
    double torque_taken_at;
    uint32_t traced;
    double trace[TRACE][8];
    Entry ring[SLOTS];
} Memory;
