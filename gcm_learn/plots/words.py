"""What the demo's page says about the scenes."""

from __future__ import annotations

TITLE = "Catching in a moving world: cognitive maps in hand-space"

LEAD = (
    "An arm with two joints has to catch a target with its hand while things move about that it "
    "must not touch. It is long and bends, so its whole limb has to be kept clear, not only the "
    "hand. All pictures on this page were computed just now.",
    "The trick: let the hand's position stand for the arm. In this hand-space the arm is one "
    "point, and every obstacle grows into the set of hand positions at which the arm would "
    "touch it, its extended obstacle. A wave starts at the hand and spreads at the hand's "
    "greatest speed. Where the front meets an extended obstacle it freezes; those cells become "
    "an effective obstacle. When the front meets the target, a catch is found.",
    "What remains is a still picture of the whole event, the cognitive map: arrival times of "
    "the front and effective obstacles. Walking down the arrival times from the target to the "
    "hand gives the path. A plan counts as caught only after the whole movement was checked, "
    "limb against bodies, also between its samples.",
    "Mental time is written τ; seconds are κ τ, with κ close to 1/400 s here. Lengths are in "
    "forearms. Panels have the letters of the paper's figures.",
)

FILM = (
    "The catch, {slower:.0f} times slower. Left: the arm among the bodies. Right: the same in "
    "hand-space, with the wave; the black dot is the hand."
)

ENGINES = "The maps of both engines at their contact, in the same colours, with the paths."

SCENES = {
    "fig1": (
        "Why stretching out fails",
        "A point is in the way of the forearm. Left: the direct way of the hand. Right: the "
        "hand positions at which the forearm touches the point form a curve, the extended "
        "obstacle.",
    ),
    "fig2": (
        "Obstacles with a size",
        "A disc and a square. Their images in hand-space are larger than they are, and "
        "overlap: for the hand they are one obstacle. The path goes round both.",
    ),
    "fig3": (
        "Obstacles that move",
        "The image of a moving obstacle moves and changes its shape on the way, since it "
        "depends on where the obstacle is relative to the shoulder.",
    ),
    "fig4": (
        "The wave and its map",
        "A point-like obstacle crosses between hand and target. The front (blue line) freezes "
        "where it meets the obstacle's image of that very moment; the image goes on, the "
        "frozen cells stay. So a moving obstacle becomes a static one in the map.",
    ),
    "fig5": (
        "A falling ball",
        "In 3D the arm stays in a plane, and only the cuts of things with that plane matter. A "
        "ball falls past a fixed bar. The hand goes round the bar's image and meets the ball. "
        "At the robot's scale the ball would fall eleven forearms in this time, so gravity is "
        "smaller here.",
    ),
    "fig6": (
        "Thrown objects",
        "A spinning bar (to catch) and a spinning disk (to avoid) fly through the arm's plane "
        "in opposite directions. At first nothing is in the plane. The part of the disk's "
        "image that appears behind the front is ignored: the hand has already left that place.",
    ),
    "fig8": (
        "The pendulum experiment",
        "At the size of a small humanoid robot: an arm of 27 cm, a cardboard box of 26 x 60 x "
        "38 cm, a tennis ball on a cord fixed at 150 cm. The box bars the direct way from the "
        "start; the ball appears in the arm's plane only when it swings through, and its cord "
        "with it.",
    ),
}

WAITING = (
    "A gate opens: a long bar slides off from between the hand and a ball. In the paper's map "
    "every cell has one time of arrival, and what froze stays frozen, so the gate stays shut; "
    "the way round it takes longer than there is time.",
    "The planner `layered` lets the hand wait. A cell may be free, then blocked, then free "
    "again; for each span in which it is free the map keeps the earliest arrival, on a sheet of "
    "its own. Here the hand comes up to the bar, rests until its end has passed, and goes on.",
)

SHEETS = (
    "Left: the movement; the sign for a pause marks where the hand rests, and for how long. "
    "Right: the sheets of the map. Grey cells have earlier arrivals only; red ones were never "
    "entered."
)

GATE_SHUT = "The same in maps of first arrivals: the front freezes along the bar."

CAPTIONS = {
    "fig1": "Fig. 1. A: the direct way is barred. B: arms that touch the point, and the curve of "
    "their hands. Dashed circles: reach of the upper arm and of the whole arm.",
    "fig2": "Fig. 2A. Left: poses on the way to the target. Right: the same path in hand-space.",
    "fig3": "Fig. 3. Two movers and their extended obstacles at four instants.",
    "fig4": "Fig. 4. A: the situation. B: the same in hand-space. C: the wave at three instants. "
    "D: the cognitive map and the path. E: three poses of the arm.",
    "fig5": "Fig. 5. A: the scene and the arm's plane. B: the cut. C: the wave. D: the movement.",
    "fig6": "Fig. 6. B: the wave. C: the movement in 3D; what is behind the plane looks dimmer.",
    "fig7": "Fig. 7B. The initial situation, seen from behind the arm, and in the arm's plane.",
    "fig8": "Fig. 8. B: the wave; at the contact the cord's image is in the upper right. "
    "C: the movement.",
}

RANDOM = (
    "Random situations with one to five moving bodies, solved by both engines, by marching with "
    "waits (layered) and, for comparison, by a straight line to the earliest interception at full "
    "speed. Unreachable says that this planner found no catch, not that there is none. Every "
    "catch was checked "
    "once more: speed limits, the catch itself and the clearance of the whole limb. A broken "
    "promise would be a catch that failed this check."
)

SPREADS = "Curves tell which share of the plans (of the catches, left two) is below a value."

READING = (
    "gcm is the neural lattice of the paper (Eq. 10); marching computes the same kind of map "
    "directly, cell by cell in order of time. The lattice's front takes about 26 τ to get going "
    "from a single cell and is slower along the axes than along the diagonals, so its contacts "
    "come later.",
    "The paper gives no dimensions for its scenes; ours are chosen to look like its figures, so "
    "instants need not be equal.",
    "Red cells near the shoulder, where no extended obstacle is drawn, are caution: close to "
    "the shoulder half a cell's step of the hand swings the arm far, and obstacles are widened "
    "by that much. When no path is found in such a map, it is made again without.",
)

BESIDE = {
    "memory": "What was caught can be remembered: [a memory of catches](memory/index.html) shows "
    "them as points, each with its map, and answers new situations with them.",
    "comparison": "[Who catches what](comparison/report.html) compares planners, memory and "
    "trained policies on the same situations.",
}

MORE = (
    "The situations of this page are in `paper.jsonl` and `gate.jsonl` beside it, one JSON "
    "object a line: copy "
    "one, change it, and run `gcm-learn solve FILE --plot pictures`. `gcm-learn --help` lists "
    "the rest.",
)
