"""The sources of a functional mock-up unit: FMI 2.0, Model Exchange, around an exported file of C.

States are the coordinates q and their rates v, inputs the drive's torques on the output side.
Names, types and meanings follow the standard (FMI 2.0.4, Functional Mock-up Interface, 2022).
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

from crosscheck.models.arm.layout import Layout

# Value references: q, v, their derivatives, the torques.
INTERFACE = """
/* The interface of FMI 2.0, Model Exchange. */
#include <stddef.h>
#include <stdlib.h>

enum { STATES = 2 * N, VARIABLES = 4 * N + JOINTS };
enum { OK = 0, ERROR = 3 };

typedef struct {
    double t, state[STATES], torque[JOINTS];
} Unit;

typedef struct {
    int needed, terminate, nominals, values, defined;
    double next;
} EventInfo;

static void derivatives(const Unit *unit, double *found) {
    for (int k = 0; k < N; k++) found[k] = unit->state[N + k];
    PREFIX_acceleration(unit->t, unit->state, unit->state + N, unit->torque, found + N);
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
                      const void *callbacks, int visible, int logging) {
    (void)name, (void)resources, (void)callbacks, (void)visible, (void)logging;
    if (kind != 0 || strcmp(guid, "GUID") != 0) return NULL; /* 0: Model Exchange */
    return calloc(1, sizeof(Unit));
}

void fmi2FreeInstance(void *c) { free(c); }

int fmi2Reset(void *c) {
    memset(c, 0, sizeof(Unit));
    return OK;
}

int fmi2SetupExperiment(void *c, int bounded, double tolerance, double start, int stops,
                        double stop) {
    (void)bounded, (void)tolerance, (void)stops, (void)stop;
    ((Unit *)c)->t = start;
    return OK;
}

int fmi2SetTime(void *c, double t) {
    ((Unit *)c)->t = t;
    return OK;
}

int fmi2SetContinuousStates(void *c, const double *x, size_t count) {
    if (count != STATES) return ERROR;
    memcpy(((Unit *)c)->state, x, sizeof ((Unit *)c)->state);
    return OK;
}

int fmi2GetContinuousStates(void *c, double *x, size_t count) {
    if (count != STATES) return ERROR;
    memcpy(x, ((Unit *)c)->state, sizeof ((Unit *)c)->state);
    return OK;
}

int fmi2GetDerivatives(void *c, double *found, size_t count) {
    if (count != STATES) return ERROR;
    derivatives(c, found);
    return OK;
}

int fmi2GetNominalsOfContinuousStates(void *c, double *x, size_t count) {
    (void)c;
    for (size_t k = 0; k < count; k++) x[k] = 1.0;
    return OK;
}

int fmi2GetReal(void *c, const unsigned *reference, size_t count, double *value) {
    const Unit *unit = c;
    double of_states[STATES];
    derivatives(unit, of_states);
    for (size_t k = 0; k < count; k++) {
        unsigned r = reference[k];
        if (r >= VARIABLES) return ERROR;
        value[k] = r < STATES       ? unit->state[r]
                   : r < 2 * STATES ? of_states[r - STATES]
                                    : unit->torque[r - 2 * STATES];
    }
    return OK;
}

int fmi2SetReal(void *c, const unsigned *reference, size_t count, const double *value) {
    Unit *unit = c;
    for (size_t k = 0; k < count; k++) {
        unsigned r = reference[k];
        if (r >= VARIABLES || (r >= STATES && r < 2 * STATES)) return ERROR;
        if (r < STATES)
            unit->state[r] = value[k];
        else
            unit->torque[r - 2 * STATES] = value[k];
    }
    return OK;
}

int fmi2NewDiscreteStates(void *c, EventInfo *info) {
    (void)c;
    memset(info, 0, sizeof *info);
    return OK;
}

int fmi2CompletedIntegratorStep(void *c, int keeps, int *event, int *terminate) {
    (void)c, (void)keeps;
    *event = *terminate = 0;
    return OK;
}

"""
# Functions that every unit must have: arguments after the instance, and what they return.
REST = {
    **dict.fromkeys(
        (
            *("EnterInitializationMode", "ExitInitializationMode", "EnterEventMode"),
            *("EnterContinuousTimeMode", "Terminate"),
        ),
        ("", "OK"),
    ),
    "SetDebugLogging": (", int on, size_t count, const char *const *categories", "OK"),
    "GetEventIndicators": (", double *x, size_t count", "OK"),
    **{
        f"{verb}{kind}": (f", const unsigned *r, size_t count, {value}", "count ? ERROR : OK")
        for kind, word in (("Integer", "int "), ("Boolean", "int "), ("String", "char *const "))
        for verb, value in (("Get", f"{word}*value"), ("Set", f"const {word}*value"))
    },
    "GetFMUstate": (", void **state", "ERROR"),
    "SetFMUstate": (", void *state", "ERROR"),
    "FreeFMUstate": (", void **state", "ERROR"),
    "SerializedFMUstateSize": (", void *state, size_t *size", "ERROR"),
    "SerializeFMUstate": (", void *state, char *bytes, size_t size", "ERROR"),
    "DeSerializeFMUstate": (", const char *bytes, size_t size, void **state", "ERROR"),
    "GetDirectionalDerivative": (
        ", const unsigned *of, size_t count, const unsigned *by, size_t known,"
        " const double *along, double *found",
        "ERROR",
    ),
}


def generate_fmu_sources(text: str, prefix: str, layout: Layout, joints: int) -> tuple[str, str]:
    """One file of C, and modelDescription.xml. text, prefix: as ``generate_c_source`` has them."""
    units = ["rad" if each.is_angle else "m" for each in layout.coordinates]
    states = list(zip(layout.names, units, strict=True))
    return generate_unit(text, prefix, states, ["N.m"] * joints)


def generate_unit(
    text: str, prefix: str, states: Sequence[tuple[str, str]], efforts: Sequence[str]
) -> tuple[str, str]:
    """The same; states: name and unit of every coordinate; efforts: units of the torques."""
    guid = hashlib.sha256(text.encode()).hexdigest()
    rest = "".join(_function(name, *how) for name, how in REST.items())
    code = text + INTERFACE.replace("PREFIX", prefix).replace("GUID", guid) + rest
    return code, _description(guid, prefix, states, efforts)


def _function(name: str, arguments: str, returned: str) -> str:
    words = [each.split("*")[-1].split()[-1] for each in arguments.split(",")[1:]]
    unused = "".join(f"(void){word}, " for word in words if word not in returned)
    head = f"int fmi2{name}(void *c{arguments})"
    return f"{head} {{\n    {unused}(void)c;\n    return {returned};\n}}\n\n"


def _description(
    guid: str, identifier: str, coordinates: Sequence[tuple[str, str]], efforts: Sequence[str]
) -> str:
    """The text of modelDescription.xml, variables in the order of their value references."""
    n, states = len(coordinates), list(coordinates)
    states += [(f"v_{name}", f"{unit}/s") for name, unit in states]
    rows = [_variable(k, *state, 'initial="exact"', 'start="0"') for k, state in enumerate(states)]
    rows += [
        _variable(
            2 * n + k, f"der({name})", f"{unit}/s", 'initial="calculated"', f'derivative="{k + 1}"'
        )
        for k, (name, unit) in enumerate(states)
    ]
    rows += [
        _variable(4 * n + j, f"torque_{j + 1}", unit, 'causality="input"', 'start="0"')
        for j, unit in enumerate(efforts)
    ]
    unknowns = "".join(f'      <Unknown index="{2 * n + k + 1}"/>\n' for k in range(2 * n))
    defined = sorted(
        {unit for _, unit in states} | {f"{unit}/s" for _, unit in states} | set(efforts)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="2.0" modelName={quoteattr(identifier)} guid="{guid}"'
        ' generationTool="crosscheck export" numberOfEventIndicators="0">\n'
        f"  <ModelExchange modelIdentifier={quoteattr(identifier)}/>\n"
        "  <UnitDefinitions>\n"
        + "".join(f'    <Unit name="{unit}"/>\n' for unit in defined)
        + "  </UnitDefinitions>\n  <ModelVariables>\n"
        + "".join(rows)
        + "  </ModelVariables>\n  <ModelStructure>\n    <Derivatives>\n"
        + unknowns
        + "    </Derivatives>\n    <InitialUnknowns>\n"
        + unknowns
        + "    </InitialUnknowns>\n  </ModelStructure>\n</fmiModelDescription>\n"
    )


def _variable(reference: int, name: str, unit: str, kind: str, of_real: str) -> str:
    causality = "" if "causality" in kind else ' causality="local"'
    return (
        f'    <ScalarVariable name={quoteattr(name)} valueReference="{reference}"'
        f' variability="continuous"{causality} {kind}>'
        f'<Real unit="{unit}" {of_real}/></ScalarVariable>\n'
    )
