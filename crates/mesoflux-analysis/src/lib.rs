//! Statistics of correlated series on plain arrays; knows nothing of the engine.
