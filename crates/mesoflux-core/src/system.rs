//! A system of particles with its box, laws and neighbor list: everything a letter can act on.

use crate::bond::{Broken, Topology};
use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::field::Fields;
use crate::integrate::{Constraint, Integrator};
use crate::interactions::{Interactions, Kind, PairTable};
use crate::lanes::Row;
use crate::neighbors::{KindOfPair, NeighborError, NeighborList};
use crate::observable::BookedStress;
use crate::pair::{
    PairNoise, PairStress, PairSums, Sweep, conservative_forces, pair_stress, pair_sums, thermostat_sweep,
    velocity_dependent_forces,
};
use crate::state::Particles;
use crate::tensor::SymmetricTensor;
use crate::vector::{Vector, add_scaled, dot};

/// A simulation that failed numerically.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// A particle's position stopped being a number, or it flew too far at once.
    #[error(
        "at step {step}: particle {particle} moved {distance:.3e} since the neighbor list was built (its speed is {speed:.3e}, \
         the conservative force on it was {force:.3e}); must stay below half the shortest side of the box, {limit:.4}. \
         Likely cause: the time step is too large for the forces, or particles overlap at the start"
    )]
    Escaped {
        /// The step, counted from the start of the run.
        step: u64,
        /// The particle's id.
        particle: u64,
        /// The way since the last list.
        distance: f64,
        /// |v|.
        speed: f64,
        /// |F|.
        force: f64,
        /// The longest way allowed.
        limit: f64,
    },
    /// A bond came to a length that its law doesn't allow.
    #[error(
        "at step {step}: the bond between the particles {first} and {second} has the length {length:.4}; must stay below \
         {longest:.4}, the longest that its law or half the box allows. \
         Likely cause: the time step is too large for the forces, or the start is too strained"
    )]
    BrokenBond {
        /// The step, counted from the start of the run.
        step: u64,
        /// The id of one particle.
        first: u64,
        /// The id of the other.
        second: u64,
        /// The bond's length.
        length: f64,
        /// The length that it must not reach.
        longest: f64,
    },
}

/// The kind of the pair of particles in two places: by their species, and by what bonds between them exclude.
fn kind_of_pair<'a>(
    interactions: &'a Interactions,
    topology: &'a Topology,
) -> impl Fn(&Particles, u32, u32) -> Kind + Sync + 'a {
    let kinds = interactions.potentials.kinds();
    move |particles, first, second| {
        let (i, j) = (first as usize, second as usize);
        let kind = PairTable::<()>::kind(particles.species[i], particles.species[j]);
        topology.exclusion(particles.id[i], particles.id[j]).kind(kind, kinds)
    }
}

/// Particles, their box and their interactions.
#[derive(Debug, Clone)]
pub struct System {
    /// The particles.
    pub particles: Particles,
    /// The box.
    pub region: PeriodicBox,
    /// The laws.
    pub interactions: Interactions,
    /// How loops are spread over threads.
    pub workers: Workers,
    /// Steps done since the start of the run.
    pub step: u64,
    topology: Topology,
    fields: Fields,
    /// Whether the integrator leaves the total momentum as it was.
    conserving: bool,
    /// kT of the integrator's noise.
    temperature: f64,
    list: NeighborList,
    force: Vec<Row>,
    /// Room for velocities, for those who need them by row.
    velocity: Vec<Row>,
    contacts_current: bool,
    forces_current: bool,
    /// The conservative stress at the present positions, once it was asked for.
    conservative_stress: Option<SymmetricTensor>,
    /// The momentum flux since the beginning of the step, where it is booked.
    pub(crate) booked: Option<BookedStress>,
    layout: u64,
}

impl System {
    /// A system at its start.
    ///
    /// # Errors
    /// A box too small for the laws' cutoffs and the skin; a skin that is not positive; positions that are no numbers.
    pub fn new(
        particles: Particles,
        region: PeriodicBox,
        interactions: Interactions,
        skin: f64,
        workers: Workers,
    ) -> Result<Self, NeighborError> {
        let list = NeighborList::new(&region, interactions.cutoff(), skin, particles.count())?;
        let mut system = Self {
            particles,
            region,
            interactions,
            workers,
            step: 0,
            topology: Topology::default(),
            fields: Fields::default(),
            conserving: true,
            temperature: 0.0,
            list,
            force: Vec::new(),
            velocity: Vec::new(),
            contacts_current: false,
            forces_current: false,
            conservative_stress: None,
            booked: None,
            layout: 0,
        };
        system.rebuild();
        Ok(system)
    }

    /// The system with bonds between its particles, and the pair laws without what the bonds exclude.
    #[must_use]
    pub fn with_bonds(mut self, topology: Topology) -> Self {
        if !topology.exclusions().is_empty() {
            self.interactions = self.interactions.with_exclusions(topology.exclusions());
        }
        self.topology = topology;
        self.rebuild();
        self
    }

    /// The system in external fields.
    #[must_use]
    pub fn with_fields(mut self, fields: Fields) -> Self {
        self.fields = fields;
        self.forces_current = false;
        self
    }

    /// The system as an integrator moves it: only that knows whether the thermostat conserves momentum.
    #[must_use]
    pub fn with_integrator(mut self, integrator: &Integrator) -> Self {
        self.conserving = integrator.conserves_momentum();
        self.temperature = integrator.temperature();
        self
    }

    /// kT of the integrator's noise.
    pub fn bath_temperature(&self) -> f64 {
        self.temperature
    }

    /// The external fields.
    pub fn fields(&self) -> &Fields {
        &self.fields
    }

    /// Along which axes the total momentum is conserved, by fields and integrator.
    pub fn conserved_momentum(&self) -> [bool; 3] {
        self.fields.conserved().map(|conserved| conserved && self.conserving)
    }

    /// The bonds.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Must be called after positions changed: rebuilds the neighbor list where its skin is spent.
    ///
    /// # Errors
    /// A particle that flew away, or whose position is no number; a broken bond.
    pub fn positions_moved(&mut self) -> Result<(), SimulationError> {
        self.follow_positions()?;
        match self.topology.broken(&self.particles, &self.region) {
            None => Ok(()),
            Some(Broken { first, second, length, longest }) => {
                Err(SimulationError::BrokenBond { step: self.step, first, second, length, longest })
            }
        }
    }

    /// Rebuilds the neighbor list where its skin is spent; bonds may have any length.
    pub(crate) fn follow_positions(&mut self) -> Result<(), SimulationError> {
        self.contacts_current = false;
        self.forces_current = false;
        self.conservative_stress = None;
        if self.list.is_spent(&self.particles, self.workers) {
            let limit = 0.5 * self.region.shortest_side();
            let distance = self.list.largest_displacement(&self.particles, self.workers);
            if !(distance < limit) {
                return Err(self.escaped(limit));
            }
            self.rebuild();
        }
        Ok(())
    }

    /// Sorts the particles anew.
    pub(crate) fn rebuild(&mut self) {
        let kinds = kind_of_pair(&self.interactions, &self.topology);
        let kind: Option<&KindOfPair> = if self.interactions.single_kind() { None } else { Some(&kinds) };
        self.list.build(&mut self.particles, kind, self.workers);
        drop(kinds);
        self.topology.follow(&self.particles.id);
        self.contacts_current = false;
        self.forces_current = false;
        self.conservative_stress = None;
        self.layout += 1;
    }

    /// Which particle went farthest, and how.
    fn escaped(&self, limit: f64) -> SimulationError {
        let way = |k: &usize| {
            let squared = self.list.displacement_squared(&self.particles, *k);
            if squared.is_nan() { f64::INFINITY } else { squared }
        };
        let k = (0..self.particles.count()).max_by(|a, b| way(a).total_cmp(&way(b))).unwrap_or(0);
        let norm = |v: Vector| dot(v, v).sqrt();
        SimulationError::Escaped {
            step: self.step,
            particle: self.particles.id[k],
            distance: way(&k).sqrt(),
            speed: norm(self.particles.velocity(k)),
            force: self.force.get(k).map_or(0.0, |force| norm(force.vector())),
            limit,
        }
    }

    /// The neighbor list with contacts at the present positions.
    pub fn contacts(&mut self) -> &NeighborList {
        self.update_contacts();
        &self.list
    }

    fn update_contacts(&mut self) {
        if !self.contacts_current {
            let kind = kind_of_pair(&self.interactions, &self.topology);
            let kind: Option<&KindOfPair> = if self.interactions.single_kind() { None } else { Some(&kind) };
            self.list.update_contacts(&self.particles, kind, self.workers);
            self.contacts_current = true;
        }
    }

    /// The list, the laws and the particles together, the contacts up to date.
    pub fn with_contacts(&mut self) -> (&NeighborList, &Interactions, &mut Particles) {
        self.update_contacts();
        (&self.list, &self.interactions, &mut self.particles)
    }

    /// The neighbor list as it is.
    pub fn list(&self) -> &NeighborList {
        &self.list
    }

    /// The conservative forces at the present positions, computed if positions have changed since the last call.
    pub fn update_forces(&mut self) {
        if !self.forces_current {
            self.update_contacts();
            self.force.resize(self.particles.count(), Row::default());
            conservative_forces(&self.list, &self.interactions, &mut self.force, self.workers);
            self.topology.add_forces(&self.particles, &self.region, &mut self.force, self.workers);
            self.fields.add_forces(&self.particles, &self.region, &mut self.force, self.workers);
            self.forces_current = true;
        }
    }

    /// Conservative, dissipative and random forces at the present positions and the given velocities, in storage order.
    pub(crate) fn velocity_dependent_forces(&mut self, velocity: &[Row], noise: &PairNoise) -> &[Row] {
        self.forces_current = false;
        self.force.resize(self.particles.count(), Row::default());
        let Self { particles, interactions, topology, fields, list, force, workers, .. } = self;
        let kinds = kind_of_pair(interactions, topology);
        let kind: Option<&KindOfPair> = if interactions.single_kind() { None } else { Some(&kinds) };
        velocity_dependent_forces(list, interactions, particles, kind, velocity, noise, force, *workers);
        topology.add_forces(particles, &self.region, force, *workers);
        fields.add_forces(particles, &self.region, force, *workers);
        force
    }

    /// Moves every particle with the velocities of one instant and the forces that were worked out last, for a time.
    pub(crate) fn kick_and_fly(&mut self, velocity: &[Row], time: f64) {
        let Self { particles, force, workers, .. } = self;
        workers.for_each_chunk_of_two(
            &mut particles.position,
            &mut particles.momentum,
            |offset, positions, momenta| {
                for (k, (position, momentum)) in positions.iter_mut().zip(momenta).enumerate() {
                    add_scaled(position, time, velocity[offset + k].vector());
                    add_scaled(momentum, time, force[offset + k].vector());
                }
            },
        );
    }

    /// Lets the pair thermostat sweep once over all pairs; returns the expected change of the flux, and ξ.
    pub(crate) fn sweep(&mut self, sweep: &Sweep, constraint: Option<&Constraint>) -> (f64, Option<f64>) {
        self.update_contacts();
        self.update_velocities();
        let Self { particles, velocity, workers, .. } = self;
        let (list, interactions) = (&self.list, &self.interactions);
        let sums = thermostat_sweep(list, interactions, particles, velocity, sweep, *workers);
        if let Some(booked) = &mut self.booked {
            booked.dissipative += sums.dissipative;
            booked.random += sums.random;
        }
        (sums.flux, self.set_momenta_by_velocities(constraint))
    }

    /// Lets `change` act on the velocities, chunk by chunk from an offset on, and gives every particle the momentum that comes of
    /// it, on the constraint if there is one; returns ξ.
    pub(crate) fn change_velocities(
        &mut self,
        constraint: Option<&Constraint>,
        change: impl Fn(&Particles, usize, &mut [Row]) + Sync,
    ) -> Option<f64> {
        self.update_velocities();
        let Self { particles, velocity, workers, .. } = self;
        workers.for_each_chunk(velocity, |offset, velocities| change(particles, offset, velocities));
        self.set_momenta_by_velocities(constraint)
    }

    /// Gives every particle the momentum of its row of velocities, on the constraint if there is one; returns ξ.
    fn set_momenta_by_velocities(&mut self, constraint: Option<&Constraint>) -> Option<f64> {
        self.set_momenta(constraint, |system, k, _| {
            let (velocity, inverse_mass) = (system.velocity[k].vector(), system.particles.inverse_mass[k]);
            velocity.map(|v| v / inverse_mass)
        })
    }

    /// Lets `work` act with the rows of the present velocities beside.
    pub(crate) fn with_velocities<T>(&mut self, work: impl FnOnce(&mut Self, &[Row]) -> T) -> T {
        self.update_velocities();
        let velocity = std::mem::take(&mut self.velocity);
        let result = work(self, &velocity);
        self.velocity = velocity;
        result
    }

    /// Brings the rows of velocities up to date with the momenta.
    fn update_velocities(&mut self) {
        let Self { particles, velocity, workers, .. } = self;
        velocity.resize(particles.count(), Row::default());
        workers.for_each_chunk(velocity, |offset, rows| {
            for (k, row) in rows.iter_mut().enumerate() {
                *row = Row::new(particles.velocity(offset + k), 0.0);
            }
        });
    }

    /// Gives every particle a new momentum, which may follow from its old one, on the constraint if there is one: p = p' + ξF with ξ = (r − G·p')/(F·G) (Wu & Shang,
    /// eqs 45, 50); returns ξ. The flux is summed before anything is written, so that momenta are written once.
    pub(crate) fn set_momenta(
        &mut self,
        constraint: Option<&Constraint>,
        new: impl Fn(&Self, usize, Vector) -> Vector + Sync,
    ) -> Option<f64> {
        let (workers, count) = (self.workers, self.particles.count());
        let mut momenta = std::mem::take(&mut self.particles.momentum);
        let multiplier = constraint.map(|Constraint { response, control, flux, .. }| {
            (flux - workers.sum(count, |k| dot(response[k].vector(), new(self, k, momenta[k])))) / control
        });
        workers.for_each_chunk(&mut momenta, |offset, momenta| {
            for (k, momentum) in momenta.iter_mut().enumerate() {
                *momentum = new(self, offset + k, *momentum);
                if let (Some(multiplier), Some(constraint)) = (multiplier, constraint) {
                    add_scaled(momentum, multiplier, constraint.force[offset + k]);
                }
            }
        });
        self.particles.momentum = momenta;
        multiplier
    }

    /// Potential energy, virial and Laplacian of pairs, bonds and fields at the present positions; the virial is that of pairs
    /// and bonds.
    pub fn pair_sums(&mut self) -> PairSums {
        self.update_contacts();
        pair_sums(&self.list, &self.interactions, &self.particles, self.workers)
            + self.topology.sums(&self.particles, &self.region)
            + self.fields.sums(&self.particles, &self.region, self.workers)
    }

    /// The stress of pairs and bonds at the present positions and momenta, without noise.
    pub fn pair_stress(&mut self) -> PairStress {
        self.with_velocities(|system, velocity| system.pair_stress_of(Some(velocity), None))
    }

    /// The stress of pairs and bonds at the present positions: see `pair::pair_stress`.
    pub(crate) fn pair_stress_of(&mut self, velocity: Option<&[Row]>, noise: Option<&PairNoise>) -> PairStress {
        self.update_contacts();
        let mut stress = pair_stress(&self.list, &self.interactions, velocity, self.temperature, noise, self.workers);
        stress.conservative += self.topology.stress(&self.particles, &self.region);
        stress
    }

    /// Books the momentum flux of a free flight over a time, where it is booked.
    pub(crate) fn book_flight(&mut self, time: f64) {
        if let Some(booked) = &mut self.booked {
            booked.kinetic += time * self.particles.kinetic_stress(self.workers);
        }
    }

    /// Books the momentum flux of the conservative forces over a time, where it is booked.
    pub(crate) fn book_conservative(&mut self, time: f64) {
        if self.booked.is_some() {
            let stress = match self.conservative_stress {
                Some(stress) => stress,
                None => self.pair_stress_of(None, None).conservative,
            };
            self.conservative_stress = Some(stress);
            self.booked.get_or_insert_default().conservative += time * stress;
        }
    }

    /// The conservative forces of the last `update_forces`, in storage order; empty before the first.
    pub fn forces(&self) -> &[Row] {
        &self.force
    }

    /// A number that changes whenever the storage order of the particles does.
    pub fn layout(&self) -> u64 {
        self.layout
    }

    /// kT as the momenta have it: Σ p²/m over 3(N − 1) degrees of freedom, the total momentum being fixed; one more for each
    /// axis along which it is not conserved.
    pub fn kinetic_temperature(&self) -> f64 {
        let fixed = self.conserved_momentum().into_iter().filter(|&conserved| conserved).count();
        let degrees = 3.0 * self.particles.count() as f64 - fixed as f64;
        self.particles.twice_kinetic_energy(self.workers) / degrees
    }
}
