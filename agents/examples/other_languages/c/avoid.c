// A chair that avoids obstacles, for a microcontroller: it needs only zenoh-pico. Usage: avoid [NAME [ENDPOINT]].
//
// Build zenoh-pico 1.x with these settings, which are fixed when the library is compiled:
//
//   cmake .. -DFRAG_MAX_SIZE=8192 -DBATCH_UNICAST_SIZE=4096 -DZ_FEATURE_UNSTABLE_API=1 -DZ_FEATURE_LIVELINESS=1
//
// FRAG_MAX_SIZE bounds the largest message that the library puts together from fragments. Its default is 4096 bytes, and a
// longer message is lost without an error. The Joined of this chair has about 1 kB and its Measures less; with a lidar of
// 180 rays Measures have up to 3 kB, and those of 1440 rays about 24 kB. BATCH_UNICAST_SIZE bounds one packet: larger
// messages are fragmented. Do not subscribe to `state` or ask for `map` here; they may be much longer.

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zenoh-pico.h>

#define LONGEST 8192  // FRAG_MAX_SIZE of the library
#define WORLD "iw/v1/main"
#define NOTHING 3.0  // MaxRange of the sensors

static char name[33] = "avoid1", instance[17], session_id[17], run[17];
static unsigned long long tick;
static z_owned_publisher_t actions;
static z_owned_mutex_t mutex;     // callbacks run in zenoh-pico's own task
static char newest[LONGEST];      // the newest Measures, or empty
static bool must_join;            // the simulator has appeared, or does not know this chair

// ---------------------------------------------------------------- just enough JSON: the contract writes no spaces

static const char *field(const char *json, const char *key) {
    char quoted[40];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *found = strstr(json, quoted);
    return found == NULL ? NULL : found + strlen(quoted);
}

static bool text(const char *json, const char *key, char *out, size_t size) {
    const char *value = field(json, key);
    if (value == NULL || *value != '"') return false;
    size_t length = strcspn(++value, "\"");
    if (length >= size) return false;
    memcpy(out, value, length);
    out[length] = '\0';
    return true;
}

// A reading without a Value has the Status `none` (nothing in range), `near` (touching) or `fault`.
static double distance(const char *json, const char *sensor) {
    char start[48];
    snprintf(start, sizeof start, "{\"Id\":\"%s\"", sensor);
    const char *found = strstr(json, start);
    if (found == NULL) return NOTHING;
    char reading[160];
    size_t length = strcspn(found, "}");
    if (length >= sizeof reading) return 0.0;
    memcpy(reading, found, length);
    reading[length] = '\0';
    const char *value = field(reading, "Value");
    if (value != NULL) return strtod(value, NULL);
    return strstr(reading, "\"none\"") != NULL ? NOTHING : 0.0;
}

// ---------------------------------------------------------------- callbacks: they only keep what arrived

static void keep(const z_loaned_bytes_t *payload, char *out) {
    z_owned_string_t bytes;
    out[0] = '\0';
    if (z_bytes_to_string(payload, &bytes) != 0) return;
    size_t length = z_string_len(z_loan(bytes));
    if (length < LONGEST) {
        memcpy(out, z_string_data(z_loan(bytes)), length);
        out[length] = '\0';
    }
    z_drop(z_move(bytes));
}

static void on_output(z_loaned_sample_t *sample, void *context) {
    (void)context;
    static char message[LONGEST];
    z_view_string_t key;
    z_keyexpr_as_view_string(z_sample_keyexpr(sample), &key);
    const char *data = z_string_data(z_loan(key));
    size_t length = z_string_len(z_loan(key));
    bool is_measures = length > 9 && memcmp(data + length - 9, "/measures", 9) == 0;
    keep(z_sample_payload(sample), message);
    z_mutex_lock(z_loan_mut(mutex));
    if (is_measures) {
        strcpy(newest, message);
    } else {
        char code[20] = "";
        text(message, "Code", code, sizeof code);
        must_join = must_join || strcmp(code, "not-joined") == 0 || strcmp(code, "session") == 0;
        fprintf(stderr, "%s\n", message);
    }
    z_mutex_unlock(z_loan_mut(mutex));
}

static void on_simulator(z_loaned_sample_t *sample, void *context) {
    (void)context;
    z_mutex_lock(z_loan_mut(mutex));
    must_join = z_sample_kind(sample) == Z_SAMPLE_KIND_PUT;
    newest[0] = '\0';
    z_mutex_unlock(z_loan_mut(mutex));
}

// ---------------------------------------------------------------- the four messages

// Returns whether the simulator has accepted this chair. Robot out, Joined or Refused in.
static bool join(z_owned_session_t *session) {
    static char robot[1024], answer[LONGEST];
    char key[80];
    int used = snprintf(robot, sizeof robot,
        "{\"Name\":\"%s\",\"Kind\":\"wheelchair\",\"Instance\":\"%s\",\"Length\":1.1,\"Width\":0.6,\"Center\":0.4,"
        "\"TopSpeed\":1.0,\"Track\":0.57,\"Proximity\":[", name, instance);
    const char *sensors[] = {"left", "front", "right"};
    for (int i = 0; i < 3; i++) {
        used += snprintf(robot + used, sizeof robot - (size_t)used,
            "%s{\"Id\":\"%s\",\"X\":0.6,\"Y\":0.0,\"Z\":0.4,\"DirectionDeg\":%d.0,\"ConeDeg\":40.0,\"MaxRange\":3.0}",
            i == 0 ? "" : ",", sensors[i], 35 - 35 * i);
    }
    snprintf(robot + used, sizeof robot - (size_t)used, "]}");
    snprintf(key, sizeof key, WORLD "/join/%s", name);

    z_view_keyexpr_t where;
    z_view_keyexpr_from_str(&where, key);
    z_owned_bytes_t payload;
    z_bytes_copy_from_str(&payload, robot);
    z_owned_encoding_t json;
    z_encoding_from_str(&json, "application/json");
    z_get_options_t options;
    z_get_options_default(&options);
    options.payload = z_move(payload);
    options.encoding = z_move(json);
    options.timeout_ms = 12000;
    z_owned_closure_reply_t closure;
    z_owned_fifo_handler_reply_t replies;
    z_fifo_channel_reply_new(&closure, &replies, 1);
    bool joined = false;
    if (z_get(z_loan(*session), z_loan(where), "", z_move(closure), &options) == 0) {
        z_owned_reply_t reply;
        while (z_recv(z_loan(replies), &reply) == Z_OK) {
            if (z_reply_is_ok(z_loan(reply))) {
                keep(z_sample_payload(z_reply_ok(z_loan(reply))), answer);
                joined = text(answer, "Session", session_id, sizeof session_id);
            } else {
                keep(z_reply_err_payload(z_reply_err(z_loan(reply))), answer);
                fprintf(stderr, "%s\n", answer);
                // `no-token`: the liveliness token has not arrived yet. Any other refusal stands.
                if (answer[0] == '{' && strstr(answer, "\"no-token\"") == NULL) exit(1);
            }
            z_drop(z_move(reply));
        }
    }
    z_drop(z_move(replies));
    run[0] = '\0';
    return joined;
}

static void respond(const char *measures) {
    char now[17];
    const char *value = field(measures, "Tick");
    if (value == NULL || !text(measures, "Run", now, sizeof now)) return;
    unsigned long long given = strtoull(value, NULL, 10);
    if (strcmp(now, run) == 0 && given < tick) return;  // it arrived after a newer one
    strcpy(run, now);
    tick = given;
    double left = distance(measures, "left"), front = distance(measures, "front"), right = distance(measures, "right");
    double free_way = left < front ? left : front;
    free_way = right < free_way ? right : free_way;
    double forward = 0.5 * (free_way - 0.5), turn = 0.15 * (left - right);
    if (forward > 0.5) forward = 0.5;
    if (free_way <= 0.5) forward = 0.0, turn = 0.3;
    char message[256];
    snprintf(message, sizeof message,
        "{\"Run\":\"%s\",\"Session\":\"%s\",\"Tick\":%llu,\"Seq\":%llu,\"LeftMotor\":%.4f,\"RightMotor\":%.4f}",
        run, session_id, tick, tick, forward - turn, forward + turn);
    z_owned_bytes_t payload;
    z_bytes_copy_from_str(&payload, message);
    z_publisher_put(z_loan(actions), z_move(payload), NULL);
}

int main(int argc, char **argv) {
    if (argc > 1) snprintf(name, sizeof name, "%s", argv[1]);
    srand((unsigned)time(NULL));  // a microcontroller has a better source
    for (int i = 0; i < 16; i++) instance[i] = "0123456789abcdef"[rand() % 16];
    z_mutex_init(&mutex);

    z_owned_config_t config;
    z_config_default(&config);
    zp_config_insert(z_loan_mut(config), Z_CONFIG_MODE_KEY, "client");
    zp_config_insert(z_loan_mut(config), Z_CONFIG_CONNECT_KEY, argc > 2 ? argv[2] : "tcp/127.0.0.1:7447");
    z_owned_session_t session;
    if (z_open(&session, z_move(config), NULL) != 0) {
        fprintf(stderr, "nobody answers\n");
        return 1;
    }
    zp_start_read_task(z_loan_mut(session), NULL);
    zp_start_lease_task(z_loan_mut(session), NULL);

    char key[96];
    z_view_keyexpr_t where;
    z_owned_closure_sample_t closure;
    z_owned_subscriber_t outputs, simulator;
    snprintf(key, sizeof key, WORLD "/out/%s/*", name);
    z_view_keyexpr_from_str(&where, key);
    z_closure(&closure, on_output, NULL, NULL);
    z_declare_subscriber(z_loan(session), &outputs, z_loan(where), z_move(closure), NULL);

    z_owned_liveliness_token_t token;
    snprintf(key, sizeof key, WORLD "/in/%s/alive/both/%s", name, instance);
    z_view_keyexpr_from_str(&where, key);
    z_liveliness_declare_token(z_loan(session), &token, z_loan(where), NULL);

    z_owned_encoding_t json;
    z_publisher_options_t options;
    z_publisher_options_default(&options);
    z_encoding_from_str(&json, "application/json");
    options.encoding = z_move(json);
    options.congestion_control = Z_CONGESTION_CONTROL_DROP;
    options.priority = Z_PRIORITY_INTERACTIVE_HIGH;
    snprintf(key, sizeof key, WORLD "/in/%s/actions", name);
    z_view_keyexpr_from_str(&where, key);
    z_declare_publisher(z_loan(session), &actions, z_loan(where), &options);

    // The simulator's token appears when it starts, and again after a restart. The chair joins each time.
    z_liveliness_subscriber_options_t history;
    z_liveliness_subscriber_options_default(&history);
    history.history = true;
    z_view_keyexpr_from_str(&where, WORLD "/alive");
    z_closure(&closure, on_simulator, NULL, NULL);
    z_liveliness_declare_subscriber(z_loan(session), &simulator, z_loan(where), z_move(closure), &history);

    static char measures[LONGEST];
    bool is_in = false;
    for (;;) {
        z_mutex_lock(z_loan_mut(mutex));
        bool join_now = must_join;
        must_join = false;
        strcpy(measures, newest);
        newest[0] = '\0';
        z_mutex_unlock(z_loan_mut(mutex));
        if (join_now) {
            is_in = join(&session);
            must_join = must_join || !is_in;
            if (!is_in) z_sleep_ms(200);
        } else if (is_in && measures[0] != '\0') {
            respond(measures);
        } else {
            z_sleep_ms(1);
        }
    }
}
