//! The course of a simulation: states, pieces of steps and their acceptance, the ledger, rest, what a run tells of itself.

pub mod accept;
pub mod balance;
pub mod closing;
pub mod contact_quantities;
pub mod diagnosis;
pub mod energy_account;
pub mod engine;
pub mod failed;
pub mod fields;
pub mod halvings;
pub mod impact;
pub mod increments;
pub mod jump;
pub mod ledger;
pub mod options;
pub mod piece;
pub mod quantities;
pub mod report;
pub mod reserve;
pub mod run_findings;
pub mod settle;
pub mod simulation;
pub mod state;
pub mod steps;
pub mod tally;
pub mod time_loop;
