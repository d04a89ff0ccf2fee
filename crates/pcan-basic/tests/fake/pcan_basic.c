/* A library with the functions of PCAN-Basic, for tests: written from the description of the interface, sharing nothing with the crate.
 *
 * What a channel does depends on its number:
 *   1  works; another node answers each data frame with the next identifier and the same bytes
 *   2  has no adapter                       3  is used by another program
 *   4  runs at 500 kbit/s for PCAN-View     5  is bus-off after the first frame
 *   6  has room for one frame               7  is unplugged after the first frame
 *   8  is error passive                     9  has no driver
 *  10  cannot listen only                  11  lost frames because nobody read them
 *  others: unknown errors
 */
#include <stdint.h>
#include <string.h>

#ifdef _WIN32
#define API __declspec(dllexport)
#define CALL __stdcall
#else
#define API __attribute__((visibility("default")))
#define CALL
#endif

typedef uint16_t Handle;
typedef uint32_t Status;

typedef struct {
    uint32_t ID;
    uint8_t MSGTYPE;
    uint8_t LEN;
    uint8_t DATA[8];
} Msg;

typedef struct {
    uint32_t millis;
    uint16_t millis_overflow;
    uint16_t micros;
} Timestamp;

enum {
    OK = 0,
    OVERRUN = 0x40,
    BUSHEAVY = 0x08,
    BUSOFF = 0x10,
    QRCVEMPTY = 0x20,
    QXMTFULL = 0x80,
    NODRIVER = 0x200,
    HWINUSE = 0x400,
    ILLHW = 0x1400,
    ILLPARAMTYPE = 0x4000,
    ILLPARAMVAL = 0x8000,
    UNKNOWN = 0x10000,
    CAUTION = 0x2000000,
    INITIALIZE = 0x4000000,
    ILLOPERATION = 0x8000000
};
enum { REMOTE = 1, EXTENDED = 2, STATUS_MESSAGE = 0x80 };
enum { LISTEN_ONLY = 0x08, BUSSPEED_NOMINAL = 0x1A };

#define CHANNELS 17
#define QUEUE 64

typedef struct {
    int open;
    int listens;
    uint16_t registers;
    unsigned written;
    Msg queue[QUEUE];
    unsigned first, count;
} Channel;

static Channel channels[CHANNELS];

static int number_of(Handle handle) {
    if (handle >= 0x51 && handle <= 0x58) return handle - 0x50;
    if (handle >= 0x509 && handle <= 0x510) return handle - 0x500;
    return 0;
}

static void put(Channel *channel, const Msg *msg) {
    if (channel->count < QUEUE)
        channel->queue[(channel->first + channel->count++) % QUEUE] = *msg;
}

API Status CALL CAN_Initialize(Handle handle, uint16_t btr0_btr1, uint8_t type, uint32_t port, uint16_t interrupt) {
    int number = number_of(handle);
    Channel *channel = &channels[number];
    (void)type, (void)port, (void)interrupt;
    switch (number) {
    case 0: return ILLPARAMVAL;
    case 2: return ILLHW;
    case 3: return HWINUSE;
    case 9: return NODRIVER;
    }
    if (number > 11) return UNKNOWN;
    if (channel->open) return HWINUSE;
    int listens = channel->listens;
    memset(channel, 0, sizeof *channel);
    channel->open = 1;
    channel->listens = listens;
    channel->registers = btr0_btr1;
    if (number == 1) {
        /* An adapter tells of itself before anything else. */
        Msg status = {0, STATUS_MESSAGE, 4, {0}};
        put(channel, &status);
    }
    if (number == 4) {
        channel->registers = 0x001C;
        return btr0_btr1 == 0x001C ? OK : CAUTION;
    }
    return OK;
}

API Status CALL CAN_Uninitialize(Handle handle) {
    Channel *channel = &channels[number_of(handle)];
    if (!channel->open) return INITIALIZE;
    channel->open = channel->listens = 0;
    return OK;
}

API Status CALL CAN_GetStatus(Handle handle) {
    int number = number_of(handle);
    Channel *channel = &channels[number];
    if (!channel->open) return INITIALIZE;
    if (number == 5 && channel->written > 0) return BUSOFF;
    if (number == 7 && channel->written > 0) return ILLHW;
    if (number == 8) return BUSHEAVY;
    return OK;
}

API Status CALL CAN_Read(Handle handle, Msg *msg, Timestamp *time) {
    int number = number_of(handle);
    Channel *channel = &channels[number];
    if (!channel->open) return INITIALIZE;
    if (number == 11 && channel->written == 0) {
        channel->written = 1;
        return OVERRUN;
    }
    if (channel->count == 0) return QRCVEMPTY;
    *msg = channel->queue[channel->first];
    channel->first = (channel->first + 1) % QUEUE;
    channel->count--;
    if (time) memset(time, 0x55, sizeof *time);
    return OK;
}

API Status CALL CAN_Write(Handle handle, Msg *msg) {
    int number = number_of(handle);
    Channel *channel = &channels[number];
    if (!channel->open) return INITIALIZE;
    if (channel->listens) return ILLOPERATION;
    if (msg->LEN > 8 || (msg->MSGTYPE & ~(REMOTE | EXTENDED))) return ILLPARAMVAL;
    if (msg->ID > (msg->MSGTYPE & EXTENDED ? 0x1FFFFFFFu : 0x7FFu)) return ILLPARAMVAL;
    if (number == 6 && channel->written > 0) return QXMTFULL;
    if (number == 5 && channel->written > 0) return BUSOFF;
    channel->written++;
    if (number == 1) {
        Msg answer = *msg;
        answer.ID++;
        put(channel, &answer);
    }
    return OK;
}

API Status CALL CAN_GetValue(Handle handle, uint8_t parameter, void *buffer, uint32_t length) {
    Channel *channel = &channels[number_of(handle)];
    if (!channel->open) return INITIALIZE;
    if (parameter != BUSSPEED_NOMINAL) return ILLPARAMTYPE;
    if (length < 4) return ILLPARAMVAL;
    /* The controller is clocked with 8 MHz. */
    uint32_t prescaler = (channel->registers >> 8 & 0x3F) + 1;
    uint32_t quanta = 1 + ((channel->registers & 0xF) + 1) + ((channel->registers >> 4 & 7) + 1);
    uint32_t speed = 8000000 / (prescaler * quanta);
    memcpy(buffer, &speed, 4);
    return OK;
}

API Status CALL CAN_SetValue(Handle handle, uint8_t parameter, void *buffer, uint32_t length) {
    int number = number_of(handle);
    uint32_t value;
    if (parameter != LISTEN_ONLY || number == 10) return ILLPARAMTYPE;
    if (length < 4) return ILLPARAMVAL;
    memcpy(&value, buffer, 4);
    channels[number].listens = value != 0;
    return OK;
}

API Status CALL CAN_GetErrorText(Status error, uint16_t language, char *buffer) {
    if (language != 0x09) return ILLPARAMVAL;
    strcpy(buffer, error == UNKNOWN ? "The error is not known" : "Something else");
    return OK;
}
