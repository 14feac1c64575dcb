/* Shared by the tests of port/: a vehicle that the core takes, and frames of the parameter
 * protocol. */
#ifndef PORT_TEST_H
#define PORT_TEST_H

#include <string.h>

#include "sway_ecu.h"
#include "swaywatch_dbc.h"
#include "unity.h"

enum { READ, WRITE, APPLY, STORE, DISCARD, VERSION, OPEN };
enum { DONE, NO_INDEX, REFUSED, NOT_STORED, NO_COMMAND, LOCKED, MOVING, FORGED, WORN };

static const uint8_t test_key[SWAY_SIPHASH_KEY] = "swaywatch tests";

static inline sway_core_config_t good_config(void)
{
    sway_core_config_t config;
    sway_core_defaults(&config);
    config.vehicle.car =
        (sway_car_t){1955000, 2690000, 1302000, 1383000, 2166000, 109300, 185200, 0, 0, 15000, 0};
    config.vehicle.trailer =
        (sway_trailer_t){2, 1880000, 10350000, 124000, 526000, 5073000, 131200, 124400, 0, 0, 0};
    return config;
}

static inline sway_port_frame_t request_frame(uint8_t command, uint16_t index, int32_t value)
{
    static uint8_t counter;
    const struct swaywatch_dbc_sway_parameter_request_t request = {
        .parameter_command = command, .parameter_index = index, .parameter_value = value};
    sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_PARAMETER_REQUEST_FRAME_ID, .dlc = 8};
    swaywatch_dbc_sway_parameter_request_pack(frame.data, &request, sizeof frame.data);
    sway_e2e_protect(frame.id, counter, frame.data);
    counter = sway_e2e_next(counter);
    return frame;
}

/* The end of a session by a holder of `key`: `opened` is the reply to OPEN, `block` what the ECU
 * would store. */
static inline sway_port_frame_t proof_frame(uint8_t command, const uint8_t *key,
                                            struct swaywatch_dbc_sway_parameter_reply_t opened,
                                            const uint8_t *block)
{
    uint8_t message[8 + SWAY_BLOCK_SIZE];
    const uint32_t tail = (uint32_t)opened.parameter_reply_value;
    message[0] = (uint8_t)opened.parameter_reply_index;
    message[1] = (uint8_t)(opened.parameter_reply_index >> 8);
    for (unsigned i = 0; i < 4U; i++) {
        message[2U + i] = (uint8_t)(tail >> (8U * i));
    }
    message[6] = command;
    message[7] = 0;
    memcpy(message + 8, block, SWAY_BLOCK_SIZE);
    const uint64_t proof = sway_siphash(key, message, sizeof message);
    return request_frame(command, (uint16_t)proof, (int32_t)(uint32_t)(proof >> 16));
}

static inline struct swaywatch_dbc_sway_parameter_reply_t reply_of(const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_parameter_reply_t reply;
    TEST_ASSERT_EQUAL_HEX16(SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID, frame->id);
    TEST_ASSERT_EQUAL_UINT8(8, frame->dlc);
    TEST_ASSERT_TRUE(sway_e2e_check(frame->id, frame->data));
    swaywatch_dbc_sway_parameter_reply_unpack(&reply, frame->data, frame->dlc);
    return reply;
}

static inline struct swaywatch_dbc_sway_fault_report_t report_of(const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_fault_report_t report;
    TEST_ASSERT_EQUAL_HEX16(SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID, frame->id);
    TEST_ASSERT_EQUAL_UINT8(8, frame->dlc);
    TEST_ASSERT_TRUE(sway_e2e_check(frame->id, frame->data));
    swaywatch_dbc_sway_fault_report_unpack(&report, frame->data, frame->dlc);
    return report;
}

#endif
