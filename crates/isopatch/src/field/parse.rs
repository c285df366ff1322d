//! From tokens to an expression, by operator precedence with explicit stacks: no recursion, whatever the nesting.

use super::error::{FormulaErrorKind, Problem};
use super::expression::{Expression, Operator, Term, TermId};
use super::token::{Function, Span, Token, TokenKind};

/// What waits for its last operand or its closing parenthesis.
#[derive(Clone, Copy, Debug)]
enum Pending {
    Operator(Operator, Span),
    Negate(Span),
    Group(Span),
    Call { function: Function, name: Span, open: Span, arguments: usize },
}

impl Pending {
    /// How tightly it binds; parentheses never give way to an operator.
    fn precedence(self) -> u8 {
        match self {
            Self::Operator(operator, _) => precedence(operator),
            Self::Negate(_) => 3,
            Self::Group(_) | Self::Call { .. } => 0,
        }
    }
}

fn precedence(operator: Operator) -> u8 {
    match operator {
        Operator::Add | Operator::Sub => 1,
        Operator::Mul | Operator::Div => 2,
        // Above unary minus: −x² is −(x²).
        Operator::Pow => 4,
        // Not written as operators.
        Operator::Min | Operator::Max => 0,
    }
}

/// The expression that the tokens make; `text` is the formula, for messages.
pub(super) fn parse(
    tokens: &[Token],
    text: &str,
    max_nesting: usize,
) -> Result<(Expression, TermId), Problem> {
    let mut parser = Parser {
        expression: Expression::default(),
        operands: Vec::new(),
        pending: Vec::new(),
        left_side: None,
        nesting: 0,
        max_nesting,
        after_operand: false,
        text,
    };
    let mut rest = tokens.iter().peekable();
    while let Some(token) = rest.next() {
        if let TokenKind::Function(function) = token.kind {
            let open = rest.next_if(|next| next.kind == TokenKind::Open).ok_or_else(|| {
                Problem::new(FormulaErrorKind::FunctionWithoutParenthesis(function.name()), token.span)
            })?;
            parser.call(function, token.span, open.span)?;
        } else {
            parser.token(token).map_err(|problem| problem.or_unmatched(unmatched_open(tokens)))?;
        }
    }
    parser.finish()
}

/// The last opening parenthesis that is never closed.
fn unmatched_open(tokens: &[Token]) -> Option<Span> {
    let mut open = Vec::new();
    for token in tokens {
        match token.kind {
            TokenKind::Open => open.push(token.span),
            TokenKind::Close => drop(open.pop()),
            _ => {}
        }
    }
    open.pop()
}

struct Parser<'a> {
    expression: Expression,
    operands: Vec<TermId>,
    pending: Vec<Pending>,
    left_side: Option<(TermId, Span)>,
    nesting: usize,
    max_nesting: usize,
    /// Is what was read last a complete operand?
    after_operand: bool,
    text: &'a str,
}

impl Parser<'_> {
    fn token(&mut self, token: &Token) -> Result<(), Problem> {
        let span = token.span;
        match &token.kind {
            TokenKind::Number(_) if self.after_operand => {
                return Err(Problem::new(FormulaErrorKind::NumberAfterOperand, span));
            }
            TokenKind::Number(value) | TokenKind::Constant(value) => {
                let id = self.expression.constant(value.clone(), span);
                self.operand(id, span);
            }
            TokenKind::Variable(axis) => {
                let id = self.expression.push(Term::Variable(*axis), span);
                self.operand(id, span);
            }
            TokenKind::Pi => {
                let id = self.expression.push(Term::Pi, span);
                self.operand(id, span);
            }
            TokenKind::Open => {
                self.multiply_implicitly(span);
                self.open(Pending::Group(span), span)?;
            }
            TokenKind::Minus if !self.after_operand => self.pending.push(Pending::Negate(span)),
            TokenKind::Plus if !self.after_operand => {}
            _ if !self.after_operand => return Err(self.expected_operand(span)),
            TokenKind::Plus => self.operator(Operator::Add, span),
            TokenKind::Minus => self.operator(Operator::Sub, span),
            TokenKind::Times => self.operator(Operator::Mul, span),
            TokenKind::Divide => self.operator(Operator::Div, span),
            TokenKind::Power => self.operator(Operator::Pow, span),
            TokenKind::Close => self.close(span)?,
            TokenKind::Comma => self.comma(span)?,
            TokenKind::Equals => self.equals(span)?,
            // Calls come with their parenthesis, through `call`.
            TokenKind::Function(function) => {
                return Err(Problem::new(
                    FormulaErrorKind::FunctionWithoutParenthesis(function.name()),
                    span,
                ));
            }
        }
        Ok(())
    }

    fn expected_operand(&self, span: Span) -> Problem {
        let found = self.text.chars().skip(span.column - 1).take(span.length).collect();
        Problem::new(FormulaErrorKind::ExpectedOperand(found), span)
    }

    /// Two operands side by side are multiplied; binds like a written ·.
    fn multiply_implicitly(&mut self, span: Span) {
        if self.after_operand {
            self.operator(Operator::Mul, span);
        }
    }

    fn operand(&mut self, id: TermId, span: Span) {
        self.multiply_implicitly(span);
        self.operands.push(id);
        self.after_operand = true;
    }

    fn operator(&mut self, operator: Operator, span: Span) {
        // Powers group to the right, everything else to the left.
        let holds = precedence(operator) + u8::from(operator == Operator::Pow);
        self.reduce(holds);
        self.pending.push(Pending::Operator(operator, span));
        self.after_operand = false;
    }

    /// Applies what waits on the stack and binds at least as tightly as `precedence`.
    fn reduce(&mut self, precedence: u8) {
        while let Some(top) = self.pending.pop_if(|top| top.precedence() >= precedence) {
            match top {
                Pending::Negate(span) => {
                    if let Some(a) = self.operands.pop() {
                        let id = self.expression.negate(a, span);
                        self.operands.push(id);
                    }
                }
                Pending::Operator(operator, span) => {
                    if let (Some(b), Some(a)) = (self.operands.pop(), self.operands.pop()) {
                        let id = self.combine(operator, a, b, span);
                        self.operands.push(id);
                    }
                }
                Pending::Group(_) | Pending::Call { .. } => {}
            }
        }
    }

    fn combine(&mut self, operator: Operator, a: TermId, b: TermId, span: Span) -> TermId {
        if operator == Operator::Pow {
            self.expression.pow(a, b, span)
        } else {
            self.expression.binary(operator, a, b, span)
        }
    }

    fn open(&mut self, pending: Pending, span: Span) -> Result<(), Problem> {
        self.nesting += 1;
        if self.nesting > self.max_nesting {
            return Err(Problem::new(FormulaErrorKind::TooDeep { limit: self.max_nesting }, span));
        }
        self.pending.push(pending);
        self.after_operand = false;
        Ok(())
    }

    fn call(&mut self, function: Function, name: Span, open: Span) -> Result<(), Problem> {
        self.multiply_implicitly(name);
        self.open(Pending::Call { function, name, open, arguments: 1 }, open)
    }

    fn comma(&mut self, span: Span) -> Result<(), Problem> {
        self.reduce(1);
        match self.pending.last_mut() {
            Some(Pending::Call { arguments, .. }) => *arguments += 1,
            _ => return Err(Problem::new(FormulaErrorKind::MisplacedComma, span)),
        }
        self.after_operand = false;
        Ok(())
    }

    fn close(&mut self, span: Span) -> Result<(), Problem> {
        self.reduce(1);
        match self.pending.pop() {
            Some(Pending::Group(_)) => {}
            Some(Pending::Call { function, name, arguments, .. }) => self.apply(function, name, arguments)?,
            _ => return Err(Problem::new(FormulaErrorKind::UnmatchedClose, span)),
        }
        self.nesting -= 1;
        self.after_operand = true;
        Ok(())
    }

    fn apply(&mut self, function: Function, name: Span, arguments: usize) -> Result<(), Problem> {
        let operator = if function == Function::Min { Operator::Min } else { Operator::Max };
        let fits = if function.is_variadic() { arguments >= 2 } else { arguments == 1 };
        if !fits {
            let expected = if function.is_variadic() { "two or more arguments" } else { "one argument" };
            let kind =
                FormulaErrorKind::ArgumentCount { function: function.name(), expected, found: arguments };
            return Err(Problem::new(kind, name));
        }
        let first = self.operands.len() - arguments;
        let arguments: Vec<TermId> = self.operands.drain(first..).collect();
        let id = if function.is_variadic() {
            let rest = arguments[1..].iter();
            rest.fold(arguments[0], |a, &b| self.expression.binary(operator, a, b, name))
        } else {
            self.expression.push(Term::Call(function, arguments[0]), name)
        };
        self.operands.push(id);
        Ok(())
    }

    fn equals(&mut self, span: Span) -> Result<(), Problem> {
        self.reduce(1);
        match (self.pending.is_empty(), self.left_side, self.operands.pop()) {
            (true, None, Some(left)) => self.left_side = Some((left, span)),
            _ => return Err(Problem::new(FormulaErrorKind::MisplacedEquals, span)),
        }
        self.after_operand = false;
        Ok(())
    }

    fn finish(mut self) -> Result<(Expression, TermId), Problem> {
        let end = Span { column: self.text.chars().count() + 1, length: 1 };
        if !self.after_operand {
            return Err(Problem::new(FormulaErrorKind::UnexpectedEnd, end));
        }
        self.reduce(1);
        if let Some(Pending::Group(span) | Pending::Call { open: span, .. }) = self.pending.last() {
            return Err(Problem::new(FormulaErrorKind::UnmatchedOpen, *span));
        }
        let Some(right) = self.operands.pop() else {
            return Err(Problem::new(FormulaErrorKind::UnexpectedEnd, end));
        };
        let root = match self.left_side {
            Some((left, span)) => self.expression.binary(Operator::Sub, left, right, span),
            None => right,
        };
        Ok((self.expression, root))
    }
}
