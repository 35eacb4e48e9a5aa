//! What chance does to genes (Saunders 2006, IV.3.2.1): what is wrong with a gene decides what is probably done to it.

use super::{
    fit::{Fit, fitting_offset, fitting_slope, misfit},
    gene::{Gene, Turn},
    ground::{Evaluation, Ground},
};
use crate::genetic::Draws;
use core::f64::consts::FRAC_PI_4;

/// What can be done to a gene.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Operator {
    /// Another mean.
    Offset,
    /// Steeper or flatter.
    Scale,
    /// Turned.
    Rotation,
    /// Another piece of the samples.
    Source,
    /// The piece beside.
    Shift,
    /// As the piece is.
    Reset,
}

const OPERATORS: [Operator; 6] = [Operator::Offset, Operator::Scale, Operator::Rotation, Operator::Source, Operator::Shift, Operator::Reset];

/// How much less a piece misfits that goes on where its neighbour's ends: between them there is no seam.
const GOES_ON: f64 = 0.6;

/// Fits below it are strays at a level's end.
const STRAY: f64 = 0.9;

/// Pieces beside that are looked at.
const BESIDE: usize = 12;

impl Ground<'_> {
    /// A genome of the first generation: gene by gene the best of pieces that chance gives and of those that go on where neighbours end.
    pub(super) fn first(&self, draws: &mut Draws) -> Vec<Gene> {
        let mut genome: Vec<Gene> = Vec::with_capacity(self.layout.count());
        for gene in 0..self.layout.count() {
            let (column, row) = (gene % self.layout.genes[0], gene / self.layout.genes[0]);
            let west = (column > 0).then(|| (gene - 1, [1, 0]));
            let north = (row > 0).then(|| (gene - self.layout.genes[0], [0, 1]));
            let beside: Vec<Gene> = [west, north].into_iter().flatten().filter_map(|(of, way)| self.goes_on(gene, of, &genome[of], way)).collect();
            genome.push(self.best(gene, &beside, self.options.looks, draws));
        }
        genome
    }

    /// The piece that goes on where another gene's ends, seen `way` from it.
    fn goes_on(&self, gene: usize, of: usize, other: &Gene, way: [i32; 2]) -> Option<Gene> {
        if self.kinds[gene] != self.kinds[of] {
            return None;
        }
        let [dx, dy] = other.turn.of(way.map(|c| c * self.layout.pitch as i32));
        let next = Gene { column: other.column + dx, row: other.row + dy, rotation: 0.0, scale: 1.0, ..*other };
        self.kind(gene).sources[next.sample as usize].holds(next.column, next.row, self.layout.reach).then_some(next)
    }

    /// The best of some pieces and of those that chance gives, at the height that fits.
    fn best(&self, gene: usize, beside: &[Gene], looks: usize, draws: &mut Draws) -> Gene {
        let (kind, target) = (self.kind(gene), &self.targets[gene]);
        let mut best = (Gene::default(), f64::INFINITY);
        let mut look = |piece: Gene, share: f64| {
            let misfit = share * misfit(&piece, kind, target, &self.layout);
            if misfit < best.1 {
                best = (piece, misfit);
            }
        };
        for piece in beside {
            look(*piece, GOES_ON);
        }
        for _ in 0..looks {
            look(kind.draw(&self.layout, draws), 1.0);
        }
        Gene { offset: fitting_offset(&best.0, kind, target), ..best.0 }
    }

    /// Takes over a rectangle of another genome.
    pub(super) fn swap(&self, child: &mut [Gene], mate: &[Gene], change: &mut Vec<usize>, draws: &mut Draws) {
        let [columns, rows] = self.layout.genes;
        let side = |genes: usize, draws: &mut Draws| 1 + draws.below((genes as f64 * self.options.crossover_width) as usize);
        let (width, height) = (side(columns, draws).min(columns), side(rows, draws).min(rows));
        let (x, y) = (draws.below(columns - width + 1), draws.below(rows - height + 1));
        for gene in (y..y + height).flat_map(|row| row * columns + x..row * columns + x + width) {
            if child[gene] != mate[gene] {
                child[gene] = mate[gene];
                change.push(gene);
            }
        }
    }

    /// Changes genes of a window, those that are wrong more probably.
    pub(super) fn mutated(&self, child: &mut [Gene], parent: &Evaluation, change: &mut Vec<usize>, draws: &mut Draws) {
        let [columns, rows] = self.layout.genes;
        let size = [columns, rows].map(|genes| genes.div_ceil(2));
        let (x, y) = (draws.below(columns - size[0] + 1), draws.below(rows - size[1] + 1));
        for gene in (y..y + size[1]).flat_map(|row| row * columns + x..row * columns + x + size[0]) {
            let region = usize::from(self.gene_regions[gene]);
            let (similar, fit) = (parent.similarities[region], &parent.fits[gene]);
            let probability = self.options.mutation * (0.5 + (1.0 - similar) / 4.0 + (1.0 - fit.value) / 4.0);
            if draws.chance(probability) {
                self.change(gene, child, [similar, parent.flatness[region]], fit, draws);
                change.push(gene);
            }
        }
    }

    /// Does something to a gene, what mends it more probably.
    fn change(&self, gene: usize, child: &mut [Gene], [similar, flatness]: [f64; 2], fit: &Fit, draws: &mut Draws) {
        let wrong = |fit: f64| 0.1 + (1.0 - fit);
        let weights = [
            0.5 * wrong(fit.mean),
            wrong(fit.slope) + 4.0 * (1.0 - flatness).abs(),
            0.5 * wrong(fit.angle),
            0.4 + (1.0 - similar) + (1.0 - fit.value),
            0.4,
            0.05,
        ];
        let (kind, target, own) = (self.kind(gene), &self.targets[gene], child[gene]);
        child[gene] = match OPERATORS[draws.weighted(&weights)] {
            Operator::Offset => {
                let most = self.options.max_offset * kind.range;
                let by = (0.5 * most * draws.normal()).clamp(-most, most);
                Gene { offset: fitting_offset(&own, kind, target) + by as f32, ..own }
            }
            Operator::Scale => {
                let scale = f64::from(own.scale) * flatness * libm::exp(0.1 * draws.normal());
                Gene { scale: scale.clamp(1.0 / self.options.max_scale, self.options.max_scale) as f32, ..own }
            }
            Operator::Rotation => self.turned(gene, own, draws),
            Operator::Source => {
                let beside = self.beside(gene, child);
                self.best(gene, &beside, self.options.looks.div_ceil(2), draws)
            }
            Operator::Shift => self.shifted(gene, own, draws),
            Operator::Reset => Gene { rotation: 0.0, scale: 1.0, offset: fitting_offset(&own, kind, target), ..own },
        };
    }

    /// Pieces that go on where neighbours end.
    fn beside(&self, gene: usize, genome: &[Gene]) -> Vec<Gene> {
        let [columns, rows] = self.layout.genes;
        let (column, row) = (gene % columns, gene / columns);
        let ways = [(column > 0, -1, 0), (column + 1 < columns, 1, 0), (row > 0, 0, -1), (row + 1 < rows, 0, 1)];
        let of = |(there, x, y): (bool, i32, i32)| {
            let of = gene.checked_add_signed(x as isize + y as isize * columns as isize).filter(|_| there)?;
            self.goes_on(gene, of, &genome[of], [-x, -y])
        };
        ways.into_iter().filter_map(of).collect()
    }

    /// Turned to about where the slope of its means is that of the pattern, as far as the sample reaches.
    fn turned(&self, gene: usize, own: Gene, draws: &mut Draws) -> Gene {
        let (_, turn) = fitting_slope(&own, self.kind(gene), &self.targets[gene]);
        let turn = f64::from(own.rotation) + turn.unwrap_or(0.0) + 0.1 * draws.normal();
        let quarters = libm::round(turn / (2.0 * FRAC_PI_4));
        let rest = (turn - quarters * 2.0 * FRAC_PI_4).clamp(-FRAC_PI_4, FRAC_PI_4);
        // A turn of the ground is one of its piece the other way round in a mirror.
        let steps = quarters as i32 * if own.turn.0 & 4 == 0 { 1 } else { -1 };
        let turned = Gene { turn: Turn((own.turn.0 & 4) | ((i32::from(own.turn.0) + steps).rem_euclid(4) as u8)), rotation: rest as f32, ..own };
        let source = &self.kind(gene).sources[own.sample as usize];
        if source.holds(own.column, own.row, turned.needs(self.layout.reach)) { turned } else { Gene { rotation: 0.0, ..turned } }
    }

    /// The best of pieces beside.
    fn shifted(&self, gene: usize, own: Gene, draws: &mut Draws) -> Gene {
        let (kind, target) = (self.kind(gene), &self.targets[gene]);
        let source = &kind.sources[own.sample as usize];
        let reach = self.layout.reach;
        let mut best = (own, f64::INFINITY);
        for _ in 0..BESIDE {
            let [x, y] = [0, 1].map(|_| draws.below(reach + 1) as i32 - (reach / 2) as i32);
            let piece = Gene { column: own.column + x, row: own.row + y, ..own };
            if (x, y) != (0, 0) && source.holds(piece.column, piece.row, piece.needs(reach)) {
                let misfit = misfit(&piece, kind, target, &self.layout);
                if misfit < best.1 {
                    best = (piece, misfit);
                }
            }
        }
        Gene { offset: fitting_offset(&best.0, kind, target), ..best.0 }
    }

    /// Gives genes that stray the transforms with which their means, slopes and directions are those of the pattern, as far as scale and sample allow; the genes that it changed.
    pub(super) fn conform(&self, genome: &mut [Gene], fits: &[Fit]) -> Vec<usize> {
        let mut changed = Vec::new();
        for (gene, fit) in fits.iter().enumerate().filter(|(_, fit)| fit.mean.min(fit.slope).min(fit.angle) < STRAY) {
            let (kind, target, own) = (self.kind(gene), &self.targets[gene], genome[gene]);
            let level = Gene { offset: fitting_offset(&own, kind, target), ..own };
            let (factor, turn) = fitting_slope(&level, kind, target);
            let scale = f64::from(own.scale) * factor.unwrap_or(1.0);
            let scaled = Gene { scale: scale.clamp(1.0 / self.options.max_scale, self.options.max_scale) as f32, ..level };
            let rotation = f64::from(own.rotation) + turn.unwrap_or(0.0);
            let turned = Gene { rotation: rotation.clamp(-FRAC_PI_4, FRAC_PI_4) as f32, ..scaled };
            let held = |piece: &Gene| kind.sources[piece.sample as usize].holds(piece.column, piece.row, piece.needs(self.layout.reach));
            let judged = |piece: Gene| (piece, Fit::new(&piece, kind, target, &self.layout).value);
            let better =
                [level, scaled, turned].into_iter().filter(held).map(judged).fold((own, fit.value), |best, other| if other.1 > best.1 { other } else { best });
            if better.0 != own {
                genome[gene] = better.0;
                changed.push(gene);
            }
        }
        changed
    }
}
