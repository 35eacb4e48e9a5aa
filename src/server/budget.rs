//! What one client may ask for: requests and seconds of evaluation, both refilled as time passes.

use super::{config::LimitsConfig, error::ApiError};
use lru::LruCache;
use std::{
    net::{IpAddr, Ipv6Addr},
    num::NonZeroUsize,
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

/// Seconds in which a budget that was used up is whole again.
const WINDOW: f64 = 10.0;

/// Clients that are remembered; who is forgotten has a whole budget again.
const REMEMBERED: NonZeroUsize = NonZeroUsize::new(1 << 16).expect("not 0");

/// Bits of an address of version 6 that tell clients apart: the rest is theirs to choose.
const PREFIX: u32 = 64;

/// Whom a budget belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Client {
    /// The hash of a key's secret.
    Key(String),
    /// An address; of version 6 its network.
    Address(IpAddr),
    /// This machine, or who came through none: without limits.
    Local,
}

impl Client {
    /// The client at an address.
    pub(super) fn at(address: IpAddr) -> Self {
        match address.to_canonical() {
            IpAddr::V4(address) if address.is_loopback() => Self::Local,
            IpAddr::V6(Ipv6Addr::LOCALHOST) => Self::Local,
            IpAddr::V6(address) => Self::Address(Ipv6Addr::from_bits(address.to_bits() & (u128::MAX << (128 - PREFIX))).into()),
            address @ IpAddr::V4(_) => Self::Address(address),
        }
    }
}

/// What a budget is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Budget {
    Requests,
    Compute,
}

impl Budget {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Requests => "requests",
            Self::Compute => "compute",
        }
    }

    /// What it counts.
    pub(super) fn what(self) -> &'static str {
        match self {
            Self::Requests => "requests",
            Self::Compute => "seconds of predicted evaluation",
        }
    }
}

/// A budget is used up: of how much in [`WINDOW`] seconds, and for how long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spent {
    pub budget: Budget,
    pub quota: f64,
    pub wait: Duration,
}

impl Spent {
    /// `RateLimit-Policy` and `RateLimit` as draft-ietf-httpapi-ratelimit-headers has them, and `Retry-After`.
    pub(super) fn fields(&self) -> [(&'static str, String); 3] {
        let (name, seconds) = (self.budget.name(), self.wait.as_secs_f64().ceil().max(1.0));
        [
            ("ratelimit-policy", format!("\"{name}\";q={};w={WINDOW}", self.quota)),
            ("ratelimit", format!("\"{name}\";r=0;t={seconds}")),
            ("retry-after", seconds.to_string()),
        ]
    }
}

impl From<Spent> for ApiError {
    fn from(spent: Spent) -> Self {
        Self::Spent(spent)
    }
}

/// What a client has left.
#[derive(Clone, Copy, Debug)]
struct Account {
    left: [f64; 2],
    at: Instant,
}

/// The budgets of all clients.
pub(super) struct Budgets {
    accounts: Mutex<LruCache<Client, Account>>,
    /// Requests and seconds in [`WINDOW`] seconds; 0 is without limit.
    quotas: [f64; 2],
}

impl Budgets {
    pub(super) fn new(limits: &LimitsConfig) -> Self {
        Self { accounts: Mutex::new(LruCache::new(REMEMBERED)), quotas: [limits.client_requests as f64, limits.client_seconds as f64] }
    }

    /// Takes some of a budget of which anything is left; a single great cost may overdraw it.
    pub(super) fn take(&self, client: &Client, budget: Budget, cost: f64, now: Instant) -> Result<(), Spent> {
        let (i, quota) = (budget as usize, self.quotas[budget as usize]);
        if quota == 0.0 || *client == Client::Local {
            return Ok(());
        }
        let mut accounts = self.accounts.lock().unwrap_or_else(PoisonError::into_inner);
        let account = accounts.get_or_insert_mut_ref(client, || Account { left: self.quotas, at: now });
        let passed = now.saturating_duration_since(account.at).as_secs_f64();
        for (left, quota) in account.left.iter_mut().zip(self.quotas) {
            *left = (*left + passed * quota / WINDOW).min(quota);
        }
        account.at = account.at.max(now);
        let least = if budget == Budget::Requests { cost } else { 0.0 };
        if account.left[i] < least || account.left[i] <= 0.0 {
            let wait = (least - account.left[i]).max(0.0) * WINDOW / quota;
            return Err(Spent { budget, quota, wait: Duration::from_secs_f64(wait) });
        }
        account.left[i] -= cost;
        Ok(())
    }

    /// Gives back what was taken and not used. Who was forgotten meanwhile has a whole budget anyway.
    pub(super) fn give_back(&self, client: &Client, budget: Budget, cost: f64) {
        let (i, quota) = (budget as usize, self.quotas[budget as usize]);
        if let Some(account) = self.accounts.lock().unwrap_or_else(PoisonError::into_inner).peek_mut(client) {
            account.left[i] = (account.left[i] + cost).min(quota);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn budgets(client_requests: u64, client_seconds: u64) -> Budgets {
        Budgets::new(&LimitsConfig { client_requests, client_seconds, ..LimitsConfig::default() })
    }

    fn address(text: &str) -> Client {
        Client::at(text.parse().expect("an address"))
    }

    #[test]
    fn a_budget_is_used_up_and_comes_back() {
        let (budgets, start, client) = (budgets(20, 5), Instant::now(), address("192.0.2.1"));
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
        for _ in 0..20 {
            assert_eq!(budgets.take(&client, Budget::Requests, 1.0, at(0.0)), Ok(()));
        }
        let spent = budgets.take(&client, Budget::Requests, 1.0, at(0.0)).expect_err("used up");
        assert_eq!(spent.fields().map(|(_, value)| value), ["\"requests\";q=20;w=10", "\"requests\";r=0;t=1", "1"].map(str::to_owned));
        assert_eq!(budgets.take(&address("192.0.2.2"), Budget::Requests, 1.0, at(0.0)), Ok(()), "others have their own");
        assert_eq!(budgets.take(&client, Budget::Requests, 1.0, at(0.6)), Ok(()), "two a second come back");
        // A tile that takes longer than there is left is made, and paid for later.
        assert_eq!(budgets.take(&client, Budget::Compute, 8.0, at(1.0)), Ok(()));
        let spent = budgets.take(&client, Budget::Compute, 0.1, at(1.0)).expect_err("overdrawn");
        assert_eq!((spent.wait.as_secs_f64().round(), budgets.take(&client, Budget::Compute, 0.1, at(7.5))), (6.0, Ok(())));
    }

    #[test]
    fn what_is_given_back_can_be_used_again_and_is_no_gain() {
        let (budgets, now, client) = (budgets(20, 5), Instant::now(), address("192.0.2.1"));
        assert_eq!(budgets.take(&client, Budget::Compute, 8.0, now), Ok(()));
        budgets.give_back(&client, Budget::Compute, 6.0);
        assert_eq!(budgets.take(&client, Budget::Compute, 3.0, now), Ok(()));
        assert!(budgets.take(&client, Budget::Compute, 0.1, now).is_err(), "5 seconds are used");
        budgets.give_back(&client, Budget::Compute, 100.0);
        assert_eq!(budgets.take(&client, Budget::Compute, 5.0, now), Ok(()));
        assert!(budgets.take(&client, Budget::Compute, 0.1, now).is_err(), "no more than the quota comes back");
        budgets.give_back(&Client::Local, Budget::Compute, 1.0);
    }

    #[test]
    fn this_machine_and_servers_without_limits_are_not_counted() {
        let now = Instant::now();
        for (budgets, client) in [(budgets(1, 1), address("127.0.0.1")), (budgets(1, 1), address("::ffff:127.0.0.1")), (budgets(0, 0), address("192.0.2.1"))] {
            for _ in 0..5 {
                assert_eq!(budgets.take(&client, Budget::Requests, 1.0, now), Ok(()));
            }
        }
    }

    #[test]
    fn a_network_of_version_6_is_one_client() {
        assert_eq!(address("2001:db8:1:2:3::4"), address("2001:db8:1:2:ffff::1"));
        assert_ne!(address("2001:db8:1:2:3::4"), address("2001:db8:1:3:3::4"));
        assert_eq!(address("::ffff:192.0.2.1"), address("192.0.2.1"));
    }
}
