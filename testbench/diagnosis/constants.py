"""The numbers of the diagnosis that nothing else determines, each with its reason (docs/diagnosis.md has the ablation)."""

ETA = 0.05  # knowledge in a sample of white residual: every model is a little wrong
HUBER = 3.0  # standard deviations beyond which a sample counts linearly, not squared (Huber 1981, ch. 7)
GRID_HZ = 12.5  # grid of the comparison
SAMPLES = 9_000  # samples of one channel that enter the normal equations; longer recordings are thinned
REFITS = 6  # mechanisms that are refitted in full in one round of the search
ITERATIONS = 10  # steps of a refit
ROUNDS = 4  # effects at most
PRIOR_UNKNOWN = 0.1  # before seeing data, that what is missing is in no catalogue
PRIOR_NOTHING = 0.5
SLOW_NOISE = 1.0  # slow noise of an instrument, in standard deviations of its quick noise
MOST_LEFT = 0.5  # share of the error above the noise that what was found may leave, to be a name
LAW_ERROR = 0.2  # of an effect: how far the laws of the catalogue are from those of a sensor
